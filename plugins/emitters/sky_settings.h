#pragma once

#include "emission.h"
#include "sun_position.h"
#include "sunsky_model.h"

/// The parameters that `sunsky` and `timed_sunsky` have in common.
namespace kinome::sunsky {

// clang-format off
#define KINOME_SUNSKY_PARAMETERS \
    {"turbidity", ParameterType::kFloat, "3", "Haze, from 1 (arctic, clear) to 10 (hazy)."}, \
    {"albedo", ParameterType::kReflectanceTexture, "0.3", "Of the ground; the same everywhere."}, \
    {"latitude", ParameterType::kFloat, "35.6894", "Degrees north."}, \
    {"longitude", ParameterType::kFloat, "139.6917", "Degrees east."}, \
    {"timezone", ParameterType::kFloat, "9", "Hours that clocks are ahead of Greenwich."}, \
    {"sun_scale", ParameterType::kFloat, "1", "Factor of the sun's radiance."}, \
    {"sky_scale", ParameterType::kFloat, "1", "Factor of the sky's radiance."}, \
    {"sun_aperture", ParameterType::kFloat, "0.5358", \
     "Angle that the sun takes up in the sky, in degrees; its light is the same."},\
    {"complex_sun", ParameterType::kBoolean, "false", \
     "A sun darker at its edge: not here, must be false."}, \
    {"to_world", ParameterType::kTransform, "identity", \
     "Rotation (or reflection): +z becomes up."}
// clang-format on

/// Parameters of a sky, except for the sun's position.
struct SkySettings {
  LightFrame frame;
  float turbidity, sun_scale, sky_scale;
  Rgb albedo;
  double half_angle;  ///< of the sun's disk [radians]

  explicit SkySettings(const Properties& props);
  /// Squared chord of the half angle in the unit sphere: 2 (1 - cos half_angle) without cancellation.
  double chord2() const { return 4 * std::pow(std::sin(half_angle / 2), 2); }
  /// Solid angle of the sun's disk [sr].
  float solid_angle() const { return static_cast<float>(std::numbers::pi * chord2()); }
  /// The factor by which a sun of this size is brighter than one of kSolarHalfAngle.
  float sun_ratio() const {
    return static_cast<float>(4 * std::pow(std::sin(kSolarHalfAngle / 2), 2) / chord2());
  }
  /// `sun`: a unit vector in the sky's own space, where +z is up; `rows` as of Model.
  Model model(const Vec3& sun, double rows = 0) const { return {turbidity, albedo, sun, rows}; }
};

/// Reads a year, month or day.
inline int read_calendar(const Properties& props, const char* name) {
  const int64_t value = props.integer(name);
  if (std::abs(value) > 9999) {
    throw props.error(name, "must be from -9999 to 9999, got " + std::to_string(value));
  }
  return static_cast<int>(value);
}

/// Returns the direction toward the sun. Throws Error if it isn't finite.
inline Vec3 read_sun_at(const Properties& props, const TimeAndPlace& at) {
  const Vec3 sun = sun_direction(at);
  if (is_finite(sun)) return sun;
  throw props.error("latitude", "and all of time and place must be finite");
}

inline float read_scale(const Properties& props, const char* name) {
  const float scale = props.real(name);
  if (!(scale >= 0 && scale <= 1e24f)) {
    throw props.error(name, "must be from 0 to 1e24, got " + std::to_string(scale));
  }
  return scale;
}
inline double read_half_angle(const Properties& props) {
  const float aperture = props.real("sun_aperture");
  if (!(aperture >= 1e-3f && aperture < 180)) {
    throw props.error("sun_aperture", "must be at least 0.001 and below 180 degrees, got " +
                                          std::to_string(aperture));
  }
  return double{aperture} / 2 * std::numbers::pi / 180;
}
inline float read_turbidity(const Properties& props) {
  const float turbidity = props.real("turbidity");
  if (!(turbidity >= 1 && turbidity <= 10)) {
    throw props.error("turbidity", "must be from 1 to 10, got " + std::to_string(turbidity));
  }
  return turbidity;
}
inline Rgb read_albedo(const Properties& props) {
  const auto albedo = props.texture("albedo");
  if (!albedo->is_uniform()) throw props.error("albedo", "must be the same everywhere");
  return albedo->eval(Vec2(0.5f));
}

inline SkySettings::SkySettings(const Properties& props)
    : turbidity(read_turbidity(props)),
      sun_scale(read_scale(props, "sun_scale")),
      sky_scale(read_scale(props, "sky_scale")),
      albedo(read_albedo(props)),
      half_angle(read_half_angle(props)) {
  frame.axes = read_rotation(props);
  if (props.boolean("complex_sun")) {
    throw props.error("complex_sun", "must be false: there is but a sun of even radiance");
  }
}

}  // namespace kinome::sunsky

#pragma once

#include "emission.h"
#include "sun_position.h"
#include "sunsky_model.h"

/// Parameters that `sunsky` and `timed_sunsky` share.
namespace kinome::sunsky {

// clang-format off
#define KINOME_SUNSKY_PARAMETERS \
    {"turbidity", ParameterType::kFloat, "3", "Haze, from 1 (arctic, clear) to 10 (hazy)."}, \
    {"albedo", ParameterType::kReflectanceTexture, "0.3", \
     "Albedo of the ground; must be uniform."}, \
    {"latitude", ParameterType::kFloat, "35.6894", "Degrees north."}, \
    {"longitude", ParameterType::kFloat, "139.6917", "Degrees east."}, \
    {"timezone", ParameterType::kFloat, "9", "Offset of local time from UTC, in hours."}, \
    {"sun_scale", ParameterType::kFloat, "1", "Scale factor of the sun's radiance."}, \
    {"sky_scale", ParameterType::kFloat, "1", "Scale factor of the sky's radiance."}, \
    {"sun_aperture", ParameterType::kFloat, "0.5358", \
     "Angular diameter of the sun, in degrees; doesn't change its irradiance."},\
    {"complex_sun", ParameterType::kBoolean, "false", \
     "Limb darkening of the sun; unsupported, must be false."}, \
    {"to_world", ParameterType::kTransform, "identity", \
     "Rotation (or reflection) of the sky, whose +z is up."}
// clang-format on

/// Parameters of a sky, except for the sun's position.
struct SkySettings {
  LightFrame frame;
  float turbidity, sun_scale, sky_scale;
  Rgb albedo;
  double half_angle;  ///< half of the sun's angular diameter [radians]

  explicit SkySettings(const Properties& props);
  /// Squared chord of half_angle in the unit sphere: 2 (1 - cos half_angle) without cancellation.
  double chord2() const { return 4 * std::pow(std::sin(half_angle / 2), 2); }
  /// Solid angle of the sun's disk [sr].
  float solid_angle() const { return static_cast<float>(std::numbers::pi * chord2()); }
  /// Factor of the radiance of a sun of this size, relative to one of kSolarHalfAngle.
  float sun_ratio() const {
    return static_cast<float>(4 * std::pow(std::sin(kSolarHalfAngle / 2), 2) / chord2());
  }
  /// `sun` is a unit vector in the sky's space, where +z is up. For `rows`, see Model.
  Model model(const Vec3& sun, double rows = 0) const { return {turbidity, albedo, sun, rows}; }
};

/// Reads a year, month or day.
inline int read_calendar(const Properties& props, const char* name) {
  const int64_t value = props.integer(name);
  if (std::abs(value) > 9999) {
    throw props.error(name, "must be between -9999 and 9999, got " + std::to_string(value));
  }
  return static_cast<int>(value);
}

/// Returns the direction toward the sun. Throws Error if it isn't finite.
inline Vec3 read_sun_at(const Properties& props, const TimeAndPlace& at) {
  const Vec3 sun = sun_direction(at);
  if (is_finite(sun)) return sun;
  throw props.error("latitude",
                    "must be finite, and so must the other parameters of time and place");
}

inline float read_scale(const Properties& props, const char* name) {
  return props.real(name, "must be between 0 and 1e24",
                    [](float scale) { return scale >= 0 && scale <= 1e24f; });
}
inline double read_half_angle(const Properties& props) {
  const float aperture = props.real("sun_aperture", "must be at least 0.001 and below 180 degrees",
                                    [](float angle) { return angle >= 1e-3f && angle < 180; });
  return double{aperture} / 2 * std::numbers::pi / 180;
}
inline Rgb read_albedo(const Properties& props) {
  const auto albedo = props.texture("albedo");
  if (!albedo->is_uniform()) throw props.error("albedo", "must be uniform, got a texture");
  return albedo->eval(Vec2(0.5f));
}

inline SkySettings::SkySettings(const Properties& props)
    : turbidity(props.real("turbidity", "must be between 1 and 10",
                           [](float t) { return t >= 1 && t <= 10; })),
      sun_scale(read_scale(props, "sun_scale")),
      sky_scale(read_scale(props, "sky_scale")),
      albedo(read_albedo(props)),
      half_angle(read_half_angle(props)) {
  frame.axes = read_rotation(props);
  if (props.boolean("complex_sun")) {
    throw props.error("complex_sun", "must be false: limb darkening is unsupported");
  }
}

}  // namespace kinome::sunsky

#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "kinome/emitter.h"
#include "kinome/properties.h"
#include "kinome/texture.h"
#include "kinome/wide/textures.h"

/// Helpers of emitters that read parameters and store samples.
namespace kinome {

/// Largest valid emission, so that products with areas and quotients by small distances stay
/// finite.
inline constexpr float kMaxEmission = 1e36f;

/// Reads the factor 'scale' on an emission.
inline float read_scale(const Properties& props) {
  return props.real("scale", "must be finite and not negative",
                    [](float scale) { return std::isfinite(scale) && scale >= 0; });
}

/// Reads a radiance, intensity or irradiance between 0 and kMaxEmission.
inline Rgb read_emission(const Properties& props, const std::string& name) {
  const Rgb value = props.color(name);
  if (!(std::min({value.x, value.y, value.z}) >= 0 && max_component(value) <= kMaxEmission)) {
    throw props.error(name, "must be between 0 and 1e36, got " + format_number(value.x) + " " +
                                format_number(value.y) + " " + format_number(value.z));
  }
  return value;
}

/// Throws Error at the parameter `name` if `factor`, or its product with the largest texel, exceeds
/// kMaxEmission.
inline void check_emission(const Properties& props, const std::string& name, const Texture& texture,
                           double factor = 1) {
  const double max_texel =
      std::max(std::abs(double{texture.max()}), std::abs(double{texture.min()}));
  if (const double emission = std::max(1., max_texel) * factor;
      !(emission <= double{kMaxEmission})) {
    throw props.error(name,
                      "makes the emission too large: with its texture, size and angle it must be "
                      "at most 1e36, got " +
                          format_number(static_cast<float>(emission / double{kMaxEmission})) + "e36");
  }
}

/// Reads an emission that may be a texture. Negative texels are kept, as in environment maps; the
/// texture warns about them.
inline std::shared_ptr<Texture> read_emission_texture(const Properties& props,
                                                      const std::string& name) {
  if (!props.has_object(name)) return make_uniform_texture(read_emission(props, name));
  auto texture = props.texture(name);
  check_emission(props, name, *texture);
  return texture;
}

/// Returns true if the scene sets `name` (a vector) instead of to_world. Throws Error if it sets
/// both.
inline bool has_in_place_of_to_world(const Properties& props, const std::string& name) {
  props.exclude("to_world", name);
  return props.has(name);
}

/// Orthonormalises a matrix that is a rotation or reflection up to rounding, such as one that a
/// scene file gives with few digits. Its transpose is then its inverse, and it keeps lengths.
inline glm::mat3 orthonormal(const glm::mat3& m) {
  glm::dmat3 axes(m);
  for (int c = 0; c < 3; ++c) {
    for (int earlier = 0; earlier < c; ++earlier) {
      axes[c] -= axes[earlier] * glm::dot(axes[earlier], axes[c]);
    }
    axes[c] = glm::normalize(axes[c]);
  }
  return glm::mat3(axes);
}

/// Reads `to_world` as a matrix whose columns are the axes of an environment in the world. A scale
/// has no effect on directions, and is ignored with a warning. (Mitsuba 3 distorts the
/// environment.)
inline glm::mat3 read_rotation(const Properties& props) {
  constexpr float kRounding = 1e-3f;
  glm::mat3 axes(props.transform("to_world").matrix());
  bool scales = false;
  for (int c = 0; c < 3; ++c) {
    const float length = glm::length(axes[c]);
    if (!(length > 0) || !std::isfinite(length)) {
      throw props.error("to_world", "must be a rotation or reflection");
    }
    scales |= !(std::abs(length * length - 1) < kRounding);
    axes[c] /= length;
  }
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(glm::dot(axes[c], axes[(c + 1) % 3])) < kRounding)) {
      throw props.error("to_world", "must be a rotation or reflection, without shear");
    }
  }
  if (scales) props.warn("to_world", "has a scale, which is ignored for directions");
  return orthonormal(axes);
}

/// Position and orientation of an emitter. The columns of `axes` are its unit axes in the world;
/// they are left-handed if to_world mirrors.
struct LightFrame {
  Vec3 origin{0.f};
  glm::mat3 axes{1.f};
  Vec3 scale{1.f};  ///< scale along each axis

  template <class V>
  V to_local(const V& v) const {
    return v * axes;
  }
  template <class V>
  V to_world(const V& v) const {
    return axes * v;
  }
};

/// Reads `to_world`. Throws Error if it has shear.
inline LightFrame read_light_frame(const Properties& props) {
  const Transform to_world = props.transform("to_world");
  LightFrame frame;
  frame.origin = to_world.point(Vec3(0.f));
  for (int c = 0; c < 3; ++c) {
    const Vec3 axis(to_world.matrix()[c]);
    frame.scale[c] = glm::length(axis);
    frame.axes[c] = axis / frame.scale[c];
  }
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(glm::dot(frame.axes[c], frame.axes[(c + 1) % 3])) < 1e-3f)) {
      throw props.error("to_world",
                        "must consist of rotation, translation and scale, without "
                        "shear");
    }
  }
  frame.axes = orthonormal(frame.axes);
  return frame;
}

/// Direction and distance from a point (or several) to an emitter.
template <class V>
struct TowardLight {
  using F = wide::formulas::NumberOf<V>;

  V d;  ///< unit
  F distance;
  F inverse_distance2;

  TowardLight(const V& p, const V& light) {
    const V to = light - p;
    distance = length(to);
    d = to / distance;
    inverse_distance2 = 1.f / sqr(distance);
  }
  /// False if the point is at the emitter, so that the direction is undefined.
  wide::formulas::MaskOf<F> valid() const {
    return inverse_distance2 > 0.f && inverse_distance2 < HUGE_VALF;
  }
};

/// Returns the direct light of a point emitter with `intensity` in this direction, or nullopt if it
/// is black.
inline std::optional<DirectSample> light_from_point(const TowardLight<Vec3>& toward,
                                                    const Rgb& intensity) {
  const Rgb radiance = intensity * toward.inverse_distance2;
  if (!toward.valid() || is_black(radiance) || !is_finite(radiance)) return std::nullopt;
  return DirectSample{toward.d, toward.distance, 1, radiance, true};
}

/// Stores samples i, i + 1, … of a block. Samples that aren't `valid` get a pdf of 0.
inline void store_direct(const DirectBlock& out, size_t i, const TowardLight<wide::Vec3>& toward,
                         wide::Mask valid, wide::Float pdf, wide::Rgb radiance, bool is_delta) {
  select(valid, toward.d, wide::Vec3(0.f, 0.f, 1.f)).store(out.d, i);
  select(valid, toward.distance, kInfinity).store(out.distance + i);
  select(valid, pdf).store(out.pdf + i);
  select(valid, radiance).store(out.radiance, i);
  select(valid, is_delta ? 1.f : 0.f).store(out.is_delta + i);
}
/// Stores light_from_point() for samples i, i + 1, … of a block.
inline void store_light_from_point(const DirectBlock& out, size_t i,
                                   const TowardLight<wide::Vec3>& toward, wide::Rgb intensity) {
  const wide::Rgb radiance = intensity * toward.inverse_distance2;
  const wide::Mask valid = toward.valid() & !is_black(radiance) & is_finite(radiance);
  store_direct(out, i, toward, valid, 1.f, radiance, true);
}

/// Stores rays i, i + 1, … of a block, which leave a point emitter. Rays that aren't `valid` get no
/// power.
inline void store_emission(const EmissionBlock& out, size_t i, const Vec3& o, wide::Vec3 d,
                           wide::Mask valid, wide::Rgb power) {
  wide::Vec3(o).store(out.o, i);
  d.store(out.d, i);
  select(valid, power).store(out.power, i);
}

}  // namespace kinome

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

/// What emitters read from a scene alike.
namespace kinome {

/// As of environment maps: products with areas, and quotients by small distances, stay finite.
inline constexpr float kMaxEmission = 1e36f;

/// Radiance, intensity or irradiance of the parameter `name`: 0 to kMaxEmission.
inline Rgb read_emission(const Properties& props, const std::string& name) {
  const Rgb value = props.color(name);
  if (!(std::min({value.x, value.y, value.z}) >= 0 && max_component(value) <= kMaxEmission)) {
    throw props.error(name, "must be finite, at most 1e36, and not negative, got " +
                                std::to_string(value.x) + " " + std::to_string(value.y) + " " +
                                std::to_string(value.z));
  }
  return value;
}

/// Of a light that a texture shapes: Error at the parameter `name` where `factor`, or that times
/// the largest texel, is beyond kMaxEmission.
inline void check_emission(const Properties& props, const std::string& name, const Texture& texture,
                           double factor = 1) {
  const double most = std::max(std::abs(double{texture.max()}), std::abs(double{texture.min()}));
  if (const double all = std::max(1., most) * factor; !(all <= double{kMaxEmission})) {
    throw props.error(name,
                      "makes the light too large: with its texture, size and angle it must be "
                      "at most 1e36, and comes to " +
                          std::to_string(all / double{kMaxEmission}) + "e36");
  }
}

/// The same as read_emission() where it may vary over a texture. A texture's own negative texels
/// are kept, as those of an environment are; it warns of them.
inline std::shared_ptr<Texture> read_emission_texture(const Properties& props,
                                                      const std::string& name) {
  for (const auto& [key, entry] : props.entries()) {
    if (key == name && std::holds_alternative<std::shared_ptr<Object>>(entry.value)) {
      auto texture = props.texture(name);
      check_emission(props, name, *texture);
      return texture;
    }
  }
  return make_uniform_texture(read_emission(props, name));
}

/// Whether the scene gives `name` (a vector) rather than to_world; Error where it gives both.
inline bool has_in_place_of_to_world(const Properties& props, const std::string& name) {
  if (props.has(name) && props.has("to_world")) {
    throw props.error("to_world", "can't be given together with " + name);
  }
  return props.has(name);
}

/// The rotation or reflection next to a matrix that is one but for rounding, as scene files write
/// them in a few digits: its transpose is then its inverse, and directions keep their length.
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

/// Reads `to_world` as a matrix whose columns are an environment's axes in the world. A scale has no
/// meaning for directions and is ignored with a warning. (Mitsuba 3 distorts the image by it.)
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
  if (scales) props.warn("to_world", "scales, which has no effect on directions");
  return orthonormal(axes);
}

/// Where a light stands, and how it is turned: columns of `axes` are its own axes in the world,
/// each of unit length. A mirroring transform mirrors the light.
struct LightFrame {
  Vec3 origin{0.f};
  glm::mat3 axes{1.f};
  Vec3 scale{1.f};  ///< of lengths along each axis

  /// Of one vector, or of several.
  template <class V>
  V to_local(const V& v) const {
    return v * axes;
  }
  template <class V>
  V to_world(const V& v) const {
    return axes * v;
  }
};

/// Of `to_world`; Error where it would bend the light.
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
      throw props.error("to_world", "must be a rotation, a translation and a scale, without shear");
    }
  }
  frame.axes = orthonormal(frame.axes);
  return frame;
}

/// The way from a point to a light, of one point or several.
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
  /// False where the point is at the light, so that there is no direction.
  wide::formulas::MaskOf<F> valid() const {
    return inverse_distance2 > 0.f && inverse_distance2 < HUGE_VALF;
  }
};

/// The light of a point that shines one way with `intensity`; nullopt where there is none.
inline std::optional<DirectSample> light_from_point(const TowardLight<Vec3>& toward,
                                                    const Rgb& intensity) {
  const Rgb radiance = intensity * toward.inverse_distance2;
  if (!toward.valid() || is_black(radiance) || !is_finite(radiance)) return std::nullopt;
  return DirectSample{toward.d, toward.distance, 1, radiance, true};
}

/// Samples i, i + 1 ... of a block; where not `valid`, there are none.
inline void store_direct(const DirectBlock& out, size_t i, const TowardLight<wide::Vec3>& toward,
                         wide::Mask valid, wide::Float pdf, wide::Rgb radiance, bool is_delta) {
  select(valid, toward.d, wide::Vec3(0.f, 0.f, 1.f)).store(out.d, i);
  select(valid, toward.distance, kInfinity).store(out.distance + i);
  select(valid, pdf).store(out.pdf + i);
  select(valid, radiance).store(out.radiance, i);
  select(valid, is_delta ? 1.f : 0.f).store(out.is_delta + i);
}
/// light_from_point for samples i, i + 1 ... of a block.
inline void store_light_from_point(const DirectBlock& out, size_t i,
                                   const TowardLight<wide::Vec3>& toward, wide::Rgb intensity) {
  const wide::Rgb radiance = intensity * toward.inverse_distance2;
  const wide::Mask valid = toward.valid() & !is_black(radiance) & is_finite(radiance);
  store_direct(out, i, toward, valid, 1.f, radiance, true);
}

/// Rays i, i + 1 ... of a block, of light that leaves a point; where not `valid`, there are none.
inline void store_emission(const EmissionBlock& out, size_t i, const Vec3& o, wide::Vec3 d,
                           wide::Mask valid, wide::Rgb power) {
  wide::Vec3(o).store(out.o, i);
  d.store(out.d, i);
  select(valid, power).store(out.power, i);
}

}  // namespace kinome

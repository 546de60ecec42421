#pragma once

#include <optional>

#include "kinome/emitter.h"
#include "kinome/light_samples.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/textures.h"

namespace kinome {

/// Disk from which light from infinitely far enters the scene. For each direction, it is
/// perpendicular to the direction, outside the scene, and its projection covers the whole scene.
/// Set once by Emitter::prepare.
class DistantDisk {
 public:
  void prepare(const Aabb& bounds) {
    if (bounds.empty()) return;
    centre_ = bounds.centre();
    // Slightly larger than the bounding sphere, to allow for rounding.
    radius_ = 0.5f * glm::length(bounds.extent()) * (1 + 1e-4f) +
              1e-6f * max_component(glm::max(glm::abs(bounds.lo), glm::abs(bounds.hi)));
  }

  /// Samples a ray along `d` whose origin is uniform over the disk, and sets its pdf_position.
  /// Returns nullopt if the scene is empty.
  std::optional<EmissionSample> sample(const Vec3& d, const Vec2& u) const {
    if (!(radius_ > 0)) return std::nullopt;
    EmissionSample sample;
    sample.o = origin(d, u);
    sample.d = d;
    sample.pdf_position = pdf();
    return sample;
  }

  /// Returns the origin of the ray. V is Vec3 or wide::Vec3.
  template <class V, class V2>
  V origin(const V& d, const V2& u) const {
    const V2 disk = warp::square_to_disk_concentric(u);
    const auto frame = FrameOf<V>::from_normal(d);
    return V(centre_) + radius_ * (frame.s * disk.x + frame.t * disk.y - d);
  }

  /// Density per area perpendicular to the direction; 0 if the scene is empty.
  float pdf() const { return radius_ > 0 ? 1 / (kPi * sqr(radius_)) : 0; }

 private:
  Vec3 centre_{0.f};
  float radius_ = 0;
};

/// Samples a ray that an environment emits: a direction by sample_direct(), and an origin on the
/// disk perpendicular to it.
inline std::optional<EmissionSample> emission_of(const Emitter& environment, const DistantDisk& disk,
                                                 const Vec2& position, const Vec2& direction) {
  const auto light = environment.sample_direct(Vec3(0.f), direction);
  if (!light) return std::nullopt;
  auto ray = disk.sample(-light->d, position);
  if (!ray) return std::nullopt;
  ray->pdf_direction = light->pdf;
  ray->power = light->radiance / (light->pdf * ray->pdf_position);
  return ray;
}

}  // namespace kinome

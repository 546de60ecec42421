#pragma once

#include "kinome/emitter.h"
#include "kinome/warp.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/textures.h"

namespace kinome {

/// Where light from infinitely far enters the scene: for each direction a disk across it, outside
/// the scene, whose shadow covers all that the scene has. Set once by Emitter::prepare.
class DistantDisk {
 public:
  void prepare(const Aabb& bounds) {
    if (bounds.empty()) return;
    centre_ = bounds.centre();
    // A little larger than the sphere around the bounds, for the sake of rounding.
    radius_ = 0.5f * glm::length(bounds.extent()) * (1 + 1e-4f) +
              1e-6f * max_component(glm::max(glm::abs(bounds.lo), glm::abs(bounds.hi)));
  }

  /// A ray that travels along `d` through a point uniform over the disk, with pdf_position; nullopt
  /// where the scene is empty.
  std::optional<EmissionSample> sample(const Vec3& d, const Vec2& u) const {
    if (!(radius_ > 0)) return std::nullopt;
    EmissionSample sample;
    sample.o = origin(d, u);
    sample.d = d;
    sample.pdf_position = pdf();
    return sample;
  }

  /// Where the ray starts, V being Vec3 or wide::Vec3.
  template <class V, class V2>
  V origin(const V& d, const V2& u) const {
    const V2 disk = warp::square_to_disk_concentric(u);
    const auto frame = FrameOf<V>::from_normal(d);
    return V(centre_) + radius_ * (frame.s * disk.x + frame.t * disk.y - d);
  }

  /// Per area across the direction; 0 where the scene is empty.
  float pdf() const { return radius_ > 0 ? 1 / (kPi * sqr(radius_)) : 0; }

 private:
  Vec3 centre_{0.f};
  float radius_ = 0;
};

}  // namespace kinome

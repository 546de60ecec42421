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

  /// A ray of an environment's light, whose direction was drawn as `light` says.
  std::optional<EmissionSample> sample_environment(const DirectSample& light, const Vec2& u) const {
    auto ray = sample(-light.d, u);
    if (!ray) return std::nullopt;
    ray->pdf_direction = light.pdf;
    ray->power = light.radiance / (light.pdf * ray->pdf_position);
    return ray;
  }
  /// The same for a block of directions, as emitter.sample_direct_block draws them.
  void sample_environment_block(const Emitter& emitter, const Columns2& position,
                                const Columns2& direction, size_t count,
                                const EmissionBlock& out) const {
    const wide::ScratchColumns scratch(6, count);
    // Where they arrive doesn't matter.
    const Columns3 unused = scratch.three(3);
    for (float* column : {unused.x, unused.y, unused.z}) std::fill_n(column, padded(count), 0.f);
    const DirectBlock light{out.d, scratch[0], scratch[1], out.power, scratch[2]};
    emitter.sample_direct_block(unused, direction, count, light);
    const float pdf_position = pdf();
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec3 d = -wide::Vec3::load(out.d, i);
      const wide::Float pdf_direction = wide::Float::load(light.pdf + i);
      origin(d, wide::Vec2::load(position, i)).store(out.o, i);
      d.store(out.d, i);
      const wide::Rgb power = wide::Rgb::load(out.power, i) / (pdf_direction * pdf_position);
      select(pdf_direction > 0.f && pdf_position > 0.f, power).store(out.power, i);
    });
  }

 private:
  Vec3 centre_{0.f};
  float radius_ = 0;
};

}  // namespace kinome

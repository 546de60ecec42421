#pragma once

#include <cstddef>

#include "kinome/blocks.h"
#include "kinome/sensor.h"
#include "transport/blocks/arena.h"

namespace kinome::transport {

/// Rays through the neighbouring pixels of a block's rays, from the same points of the lens:
/// Mitsuba's ray differentials. Not thread-safe: use one per thread.
class NextRays {
 public:
  /// Allocates memory for blocks of at most `rays` rays. `distance` is the distance of the
  /// neighbours in pixels.
  NextRays(const Sensor& sensor, float distance, size_t rays)
      : sensor_(sensor),
        distance_(distance),
        arena_(rays + kBlockLanes),
        position_(arena_.two()),
        next_{arena_.ray_hits(), arena_.ray_hits()} {}

  void find(const Columns2& position, const Columns2& aperture, size_t count) {
    for (int axis = 0; axis < 2; ++axis) {
      for (size_t i = 0; i < padded(count); ++i) {
        position_.x[i] = position.x[i] + (axis == 0 ? 1.f : 0.f);
        position_.y[i] = position.y[i] + (axis == 1 ? 1.f : 0.f);
      }
      sensor_.sample_ray_block(position_, aperture, count, next_[axis]);
    }
  }

  /// Returns the ray of the pixel to the right (axis 0) or below (axis 1), moved toward `ray` so
  /// that their distance is that of the constructor.
  Ray at(size_t i, const Ray& ray, int axis) const {
    Ray next = ray_of(&next_[axis][i / kBlockLanes].ray, i % kBlockLanes);
    // In Mitsuba's pinhole camera, the neighbours' rays begin at the ray's own origin on the near
    // plane.
    const bool is_pinhole = !sensor_.needs_aperture_sample() && next.o == ray.o;
    const Vec3 from = ray.o + ray.tmin * ray.d;
    next.o = is_pinhole ? from : from + distance_ * (next.o + next.tmin * next.d - from);
    next.d = ray.d + distance_ * (next.d - ray.d);
    return next;
  }

 private:
  const Sensor& sensor_;
  float distance_;
  Arena arena_;
  Columns2 position_;
  RayHit16* next_[2];
};

}  // namespace kinome::transport

#pragma once

#include "direction_sort.h"
#include "kinome/scene.h"

namespace kinome::transport {

/// Traces the shadow rays of a block for occlusion, sorted by direction. One per thread.
class Occlusion {
 public:
  /// For arrays of at most `places` rays, of which no more than `rays` are on.
  Occlusion(size_t places, size_t rays);
  explicit Occlusion(size_t rays) : Occlusion(rays, rays) {}

  /// Sets tmax of each ray that is on and occluded to -infinity.
  void trace(const Scene& scene, Ray16* rays, size_t count, RenderCounters& counters);
  /// The same without sorting, for rays whose neighbours are similar already. Rays of the last
  /// block behind `count` must be off.
  static void trace_in_place(const Scene& scene, Ray16* rays, size_t count,
                             RenderCounters& counters);

 private:
  DirectionSort sort_;
  Arena arena_;
  Ray16* sorted_;
};

}  // namespace kinome::transport

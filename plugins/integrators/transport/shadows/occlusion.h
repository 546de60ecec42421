#pragma once

#include "kinome/scene.h"
#include "transport/shadows/direction_sort.h"

namespace kinome::transport {

/// Traces the shadow rays of a block for occlusion, sorted by direction. Not thread-safe: use one
/// per thread.
class Occlusion {
 public:
  /// Allocates memory for arrays of at most `places` rays, of which at most `rays` are active.
  Occlusion(size_t places, size_t rays);
  explicit Occlusion(size_t rays) : Occlusion(rays, rays) {}

  /// Sets tmax of each occluded active ray to -infinity.
  void trace(const Scene& scene, Ray16* rays, size_t count, RenderCounters& counters);
  /// The same without sorting, for rays that are already similar to their neighbours. Rays of the
  /// last block after `count` must be inactive.
  static void trace_in_place(const Scene& scene, Ray16* rays, size_t count,
                             RenderCounters& counters);

 private:
  DirectionSort sort_;
  Arena arena_;
  Ray16* sorted_;
};

}  // namespace kinome::transport

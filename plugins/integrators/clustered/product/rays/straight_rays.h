#pragma once

#include <span>
#include <vector>

#include "transport/shadows/straight_shadows.h"

namespace kinome {

/// Number of surfaces that light may pass straight along one edge of a path that has `edges` edges
/// otherwise. Each such surface counts as an edge.
inline uint32_t passes_left(uint32_t max_depth, uint32_t edges) {
  return max_depth > edges ? max_depth - edges : 0;
}

/// Number of rays of one call to Embree, which fits the caches.
inline constexpr size_t kRaysPerCall = 2048;

/// Shadow rays that pass surfaces straight (Lobe::kNull), one surface after another. One object per
/// thread.
class StraightRays {
 public:
  /// Makes room for `count` rays at a time.
  StraightRays(const transport::SceneTable& scene, size_t count);

  /// Sets ray `i` of the next trace(), which passes at most `max_passes` surfaces. Its direction
  /// must be a unit vector and its tmin 0. A negative tmax disables it.
  void set(size_t i, const Ray& ray, uint32_t max_passes);
  /// Traces the first `count` rays. All of them must be set. Counts them as shadow rays.
  void trace(size_t count, RenderCounters& counters);
  /// Transmittance along a ray of the last trace(); 0 if it is disabled or blocked.
  Rgb transmittance(size_t i) const { return shadows_.transmittance().at(i); }

 private:
  transport::StraightShadows shadows_;
  transport::Arena arena_;
  Ray16* rays_;
  float* max_passes_;
};

/// Returns the mean transmittance of each shadow ray, or 0 if it is disabled. `passing`: see
/// ShadowRays. Modifies the rays.
std::vector<float> arriving_shares(const Scene& scene, const transport::SceneTable* passing,
                                   std::span<Ray> rays, RenderCounters& counters);

}  // namespace kinome

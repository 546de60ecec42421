#include "transport/shadows/occlusion.h"

#include <algorithm>

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

Occlusion::Occlusion(size_t places, size_t rays)
    : sort_(places), arena_(rays), sorted_(arena_.rays()) {}

void Occlusion::trace(const Scene& scene, Ray16* rays, size_t count, RenderCounters& counters) {
  const size_t on = sort_.sort(rays, count);
  if (on == 0) return;
  sort_.copy(sorted_, sizeof(Ray16));
  scene.occluded(sorted_, padded(on) / kBlockLanes, Coherence::kIncoherent, counters);
  for_lanes(on, [&](size_t i) {
    const Mask met = Float::load(sorted_[i / kBlockLanes].tmax + i % kBlockLanes) < -1.f;
    if (none(met)) return;
    uint32_t which[kLanes];
    const size_t n = store_selected(met, Uint::load(sort_.order() + i), which);
    for (size_t k = 0; k < n; ++k) rays[which[k] / 16].tmax[which[k] % 16] = -kInfinity;
  });
}

void Occlusion::trace_in_place(const Scene& scene, Ray16* rays, size_t count,
                               RenderCounters& counters) {
  const size_t blocks = padded(count) / kBlockLanes;
  for (size_t k = 0; k < blocks; ++k) std::fill_n(rays[k].mask, kBlockLanes, ~0u);
  scene.occluded(rays, blocks, Coherence::kIncoherent, counters);
}

}  // namespace kinome::transport

#include "occlusion.h"

namespace kinome::transport {

Occlusion::Occlusion(size_t places, size_t rays)
    : sort_(places), arena_(rays), sorted_(arena_.rays()) {}

void Occlusion::trace(const Scene& scene, Ray16* rays, size_t count, RenderCounters& counters) {
  const size_t on = sort_.sort(rays, count);
  if (on == 0) return;
  sort_.copy(rays, sorted_, sizeof(Ray16));
  scene.occluded(sorted_, padded(on) / kBlockLanes, Coherence::kIncoherent, counters);
  const uint32_t* const order = sort_.order();
  for (size_t i = 0; i < on; ++i) {
    rays[order[i] / 16].tmax[order[i] % 16] = sorted_[i / 16].tmax[i % 16];
  }
}

}  // namespace kinome::transport

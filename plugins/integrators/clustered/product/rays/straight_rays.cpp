#include "clustered/product/rays/straight_rays.h"

#include <algorithm>

#include "clustered/product/tiles/spread.h"

namespace kinome {

StraightRays::StraightRays(const transport::SceneTable& scene, size_t count)
    : shadows_(scene, padded(count), padded(count)),
      arena_(count),
      rays_(arena_.rays()),
      max_passes_(arena_.floats()) {}

void StraightRays::set(size_t i, const Ray& ray, uint32_t max_passes) {
  set_ray(rays_[i / kBlockLanes], i % kBlockLanes, ray);
  max_passes_[i] = static_cast<float>(max_passes);
}

void StraightRays::trace(size_t count, RenderCounters& counters) {
  disable_padding(rays_, count);
  shadows_.trace(rays_, count, max_passes_, counters);
  counters[RayKind::kShadow] += count;
}

std::vector<float> arriving_shares(const Scene& scene, const transport::SceneTable* passing,
                                   std::span<Ray> rays, RenderCounters& counters) {
  std::vector<float> shares(rays.size());
  if (rays.empty()) return shares;
  if (!passing) {
    scene.occluded(rays, Coherence::kIncoherent, counters);
    counters[RayKind::kShadow] += rays.size();
    for (size_t i = 0; i < rays.size(); ++i) shares[i] = rays[i].is_occluded() ? 0.f : 1.f;
    return shares;
  }
  StraightRays straight(*passing, std::min(rays.size(), kRaysPerCall));
  for (size_t begin = 0; begin < rays.size(); begin += kRaysPerCall) {
    const size_t count = std::min(kRaysPerCall, rays.size() - begin);
    for (size_t i = 0; i < count; ++i) straight.set(i, rays[begin + i], ~0u);
    straight.trace(count, counters);
    for (size_t i = 0; i < count; ++i) shares[begin + i] = mean_of(straight.transmittance(i));
  }
  return shares;
}

}  // namespace kinome

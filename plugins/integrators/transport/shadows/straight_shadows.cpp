#include "transport/shadows/straight_shadows.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/vectors.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

StraightShadows::StraightShadows(const SceneTable& scene, size_t points, size_t rays)
    : scene_(scene),
      sort_(points),
      met_(scene, rays),
      per_point_(points),
      per_ray_(rays),
      per_met_(Surfaces::max_points(scene, rays)),
      transmittance_(per_point_.three()),
      probability_(per_point_.floats()),
      passes_(per_point_.floats()),
      rays_(per_ray_.ray_hits()),
      waves_{{per_ray_.indices(), per_ray_.three(), per_ray_.floats()},
             {per_ray_.indices(), per_ray_.three(), per_ray_.floats()}},
      through_{per_met_.three(), per_met_.floats()} {}

void StraightShadows::trace(const Ray16* rays, size_t count, const float* max_passes,
                            RenderCounters& counters) {
  size_t on = begin(rays, count);
  for (uint32_t passes = 0; on > 0; ++passes) {
    clear_hits(rays_, on);
    scene_.scene().intersect(rays_, padded(on) / kBlockLanes, Coherence::kIncoherent, counters);
    met_.find(rays_, on, Surfaces::Which::kPassing);
    const Wave& wave = waves_[passes % 2];
    arrive(wave, static_cast<float>(passes));
    on = pass(rays, max_passes, static_cast<float>(passes), wave, waves_[(passes + 1) % 2]);
    counters[RayKind::kShadow] += on;
  }
}

/// Makes the first wave and returns the number of its rays.
size_t StraightShadows::begin(const Ray16* rays, size_t count) {
  for_lanes(count, [&](size_t i) { wide::Vec3(0.f).store(transmittance_, i); });
  const size_t on = sort_.sort(rays, count);
  if (on == 0) return 0;
  sort_.copy(&rays_[0].ray, sizeof(RayHit16));
  const Wave& wave = waves_[0];
  std::copy_n(sort_.order(), padded(on), wave.from);
  for_lanes(on, [&](size_t i) {
    wide::Vec3(1.f).store(wave.transmittance, i);
    Float(1.f).store(wave.probability + i);
  });
  return on;
}

void StraightShadows::arrive(const Wave& wave, float passes) {
  for (const uint32_t i : met_.missed()) {
    const uint32_t k = wave.from[i];
    transmittance_.set(k, wave.transmittance.at(i));
    probability_[k] = wave.probability[i];
    passes_[k] = passes;
  }
}

/// Makes the next wave from the rays that go straight on after `passes` surfaces. Returns the
/// number of its rays.
size_t StraightShadows::pass(const Ray16* rays, const float* max_passes, float passes,
                             const Wave& wave, const Wave& next) {
  const SurfaceBlock& points = met_.points();
  size_t count = 0;
  for (const Surfaces::Range& range : met_.ranges()) {
    range.row->bsdf->null_transmission_block(points.part(range.first, range.count),
                                             through_.from(range.first));
    for (size_t i = range.first; i < range.first + range.count; ++i) {
      const uint32_t before = points.ray[i], k = wave.from[before];
      const kinome::Rgb transmittance =
          wave.transmittance.at(before) * through_.transmittance.at(i);
      if (!(passes < max_passes[k]) || is_black(transmittance)) continue;
      next.from[count] = k;
      next.transmittance.set(count, transmittance);
      next.probability[count] = wave.probability[before] * through_.probability[i];
      Ray ray = ray_of(rays, k);
      const float distance =
          distance_behind(ray, points.p.at(i), points.n.at(i), points.p_error[i]);
      ray.o += distance * ray.d;
      // Ends where the whole ray ends.
      ray.tmax = std::max(ray.tmax - distance, 0.f);
      set_ray(rays_[count / kBlockLanes].ray, count % kBlockLanes, ray);
      ++count;
    }
  }
  disable_padding(rays_, count);
  return count;
}

}  // namespace kinome::transport

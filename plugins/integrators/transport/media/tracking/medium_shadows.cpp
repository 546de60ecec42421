#include "transport/media/tracking/medium_shadows.h"

#include <algorithm>

#include "kinome/wide/functions.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

MediumShadows::Wave MediumShadows::make_wave(Arena& arena) {
  return {arena.indices(), arena.indices(), arena.floats(), arena.floats(), arena.three()};
}

MediumShadows::MediumShadows(const SceneTable& scene, const MediaTable& media, size_t points,
                             size_t rays)
    : scene_(scene),
      media_(media),
      sort_(points),
      met_(scene, rays),
      per_point_(points),
      per_ray_(rays),
      per_met_(Surfaces::max_points(scene, rays)),
      transmittance_(per_point_.three()),
      rays_{per_ray_.ray_hits(), per_ray_.ray_hits()},
      waves_{make_wave(per_ray_), make_wave(per_ray_)},
      through_{per_met_.three(), per_met_.floats()},
      tracking_(media, rays) {}

void MediumShadows::trace(const Ray16* rays, size_t count, const uint32_t* medium,
                          const float* distance, const uint32_t* owner, const RandomSeeds& seeds,
                          RenderCounters& counters) {
  size_t on = begin(rays, count, medium, distance);
  for (uint32_t legs = 0; on > 0 && legs <= kMaxLegs; ++legs) {
    const size_t leg = legs % 2;
    counters[RayKind::kShadow] += on;
    clear_hits(rays_[leg], on);
    scene_.scene().intersect(rays_[leg], padded(on) / kBlockLanes, Coherence::kIncoherent,
                             counters);
    const Wave& wave = waves_[leg];
    travel(wave, on, rays_[leg]);
    met_.find(rays_[leg], on, Surfaces::Which::kPassing);
    if (media_.has_grids()) track(leg, owner, seeds.after(legs));
    for (const uint32_t i : met_.missed())
      transmittance_.set(wave.from[i], wave.transmittance.at(i));
    on = pass(leg);
  }
}

/// Makes the first wave and returns the number of its rays.
size_t MediumShadows::begin(const Ray16* rays, size_t count, const uint32_t* medium,
                            const float* distance) {
  for_lanes(count, [&](size_t i) { wide::Vec3(0.f).store(transmittance_, i); });
  const size_t on = sort_.sort(rays, count);
  if (on == 0) return 0;
  sort_.copy(&rays_[0][0].ray, sizeof(RayHit16));
  for (size_t k = 0; k < padded(on) / kBlockLanes; ++k) {
    std::fill_n(rays_[0][k].ray.tmin, kBlockLanes, 0.f);
  }
  const Wave& wave = waves_[0];
  std::copy_n(sort_.order(), padded(on), wave.from);
  for_lanes(on, [&](size_t i) {
    const Int from = Int::load(wave.from + i);
    gather(medium, from).store(wave.medium + i);
    gather(distance, from).store(wave.left + i);
    Float::load(rays_[0][i / kBlockLanes].ray.tmax + i % kBlockLanes).store(wave.end + i);
    wide::Vec3(1.f).store(wave.transmittance, i);
  });
  return on;
}

/// Multiplies transmittances by those of the media up to the next surface, or to the light.
void MediumShadows::travel(const Wave& wave, size_t count, const RayHit16* rays) const {
  for_lanes(count, [&](size_t i) {
    const Int medium = Int::load(wave.medium + i);
    if (all(medium == 0)) return;
    const RayHit16& block = rays[i / kBlockLanes];
    const size_t lane = i % kBlockLanes;
    const Mask hits = Uint::load(block.shape + lane) != kNoHit;
    const Float end = min(Float::load(wave.left + i), media_.end_of_space(block.ray, lane, hits));
    const Float travelled = select(hits, Float::load(block.ray.tmax + lane), end);
    const wide::Rgb extinction = gather(media_.extinction(), medium);
    const Float red = exp(-extinction.x * travelled);
    const wide::Rgb transmittance =
        media_.is_coloured()
            ? wide::Rgb(red, exp(-extinction.y * travelled), exp(-extinction.z * travelled))
            : wide::Rgb(red);
    (wide::Rgb::load(wave.transmittance, i) * transmittance).store(wave.transmittance, i);
  });
}

/// The same as travel() for media that aren't uniform. Rays that surfaces stop are left out.
void MediumShadows::track(size_t leg, const uint32_t* owner, const RandomSeeds& seeds) {
  const Wave& wave = waves_[leg];
  const auto add = [&](uint32_t i, bool hits) {
    if (!media_.grid(wave.medium[i])) return;
    const Ray ray = ray_of(&rays_[leg][i / kBlockLanes].ray, i % kBlockLanes);
    const float end = hits ? ray.tmax : std::min(wave.left[i], media_.end_of_space(ray));
    tracking_.add(wave.medium[i], ray.o, ray.d, end, seeds.of(owner[wave.from[i]]), i);
  };
  for (const uint32_t i : met_.missed()) add(i, false);
  for (const Surfaces::Range& range : met_.ranges()) {
    for (size_t i = range.first; i < range.first + range.count; ++i)
      add(met_.points().ray[i], true);
  }
  tracking_.find_transmittances(wave.transmittance);
}

/// Makes the next wave from the rays that go straight on. Returns the number of its rays.
size_t MediumShadows::pass(size_t leg) {
  const SurfaceBlock& points = met_.points();
  const RayHit16* const rays = rays_[leg];
  RayHit16* const beyond = rays_[1 - leg];
  const Wave &wave = waves_[leg], &next = waves_[1 - leg];
  size_t count = 0;
  for (const Surfaces::Range& range : met_.ranges()) {
    range.row->bsdf->null_transmission_block(points.part(range.first, range.count),
                                             through_.from(range.first));
    const uint32_t shape = rays[points.ray[range.first] / 16].shape[points.ray[range.first] % 16];
    for (size_t i = range.first; i < range.first + range.count; ++i) {
      const uint32_t before = points.ray[i];
      const kinome::Rgb transmittance =
          wave.transmittance.at(before) * through_.transmittance.at(i);
      if (is_black(transmittance)) continue;
      next.from[count] = wave.from[before];
      next.transmittance.set(count, transmittance);
      Ray ray = ray_of(&rays[before / 16].ray, before % 16);
      const float distance = continue_behind(points, i, ray);
      next.medium[count] = media_.behind(shape, points.n.at(i), ray.d, wave.medium[before]);
      next.left[count] = std::max(wave.left[before] - distance, 0.f);
      // Ends where the whole ray ends.
      ray.tmax = std::max(wave.end[before] - distance, 0.f);
      next.end[count] = ray.tmax;
      set_ray(beyond[count / kBlockLanes].ray, count % kBlockLanes, ray);
      ++count;
    }
  }
  for (size_t i = count; i < padded(count); ++i) next.medium[i] = MediaTable::kVacuum;
  disable_padding(beyond, count);
  return count;
}

}  // namespace kinome::transport

#include "caustics.h"

#include <algorithm>
#include <cmath>

#include "kinome/adjoint.h"
#include "kinome/owen.h"
#include "kinome/primary_rays.h"
#include "spread.h"

namespace kinome {
namespace {

/// Paths of one call to Embree.
constexpr uint32_t kBatch = 1024;
/// Random numbers of one path, beside those of its lamp.
enum Number : uint32_t { kLobe, kLobeX, kLobeY, kLensX, kLensY };
/// What a path's lamp takes of Sobol points: which, where, whereto.
enum Purpose : uint64_t { kWhich = 1, kPlace, kDirection };

Vec2 sobol_point(uint64_t seed, Purpose purpose, uint32_t index) {
  const uint64_t key = hash_words(seed, purpose);
  // An order of its own: else all purposes would draw the same point of the sequence.
  return owen_sobol_point(owen_scramble(index, hash_words(key, 2)), key, hash_words(key, 1));
}

}  // namespace

/// On their way.
struct Caustics::Paths {
  struct Path {
    uint32_t index;
    Rgb power;  ///< that arrives at the next point [W]
  };
  std::vector<Path> paths;
  std::vector<RayHit> rays;  ///< of each path, to its next point
  std::vector<Ray> shadow_rays;
  struct Splat {
    Vec2 position;
    Rgb value;
  };
  std::vector<Splat> splats;  ///< what arrives if nothing is in the way
};

bool Caustics::serves(const Sensor& sensor) {
  const Rect& crop = sensor.film().crop();
  const Vec2 centre(0.5f * static_cast<float>(crop.x0 + crop.x1),
                    0.5f * static_cast<float>(crop.y0 + crop.y1));
  const Ray ray = sensor.sample_ray(centre, Vec2(0.5f));
  const float t = std::min(std::max(1.f, 2 * ray.tmin), 0.5f * (ray.tmin + ray.tmax));
  return sensor.connect(ray.o + ray.d * t, Vec2(0.5f)).has_value();
}

void Caustics::emit(uint64_t seed, uint32_t first, uint32_t end, Paths& paths) const {
  for (uint32_t i = first; i < end; ++i) {
    const auto sample =
        light_.sample_lamp(sobol_point(seed, kWhich, i).x, sobol_point(seed, kPlace, i),
                           sobol_point(seed, kDirection, i));
    if (!sample || is_black(sample->power)) continue;
    paths.paths.push_back({i, sample->power});
    paths.rays.push_back({sample->ray(), Hit{}});
  }
}

/// From where rays() meet what mirrors; other paths end.
void Caustics::reflect(uint64_t seed, Paths& paths) const {
  size_t count = 0;
  for (size_t k = 0; k < paths.paths.size(); ++k) {
    if (!paths.rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(paths.rays[k]);
    const Bsdf& bsdf = si.shape->bsdf();
    Lobe lobes = bsdf.lobes() & Lobe::kDelta;
    if (light_.has_glossy_caustics() && lobe_width(si) == LobeWidth::kMirroring) {
      lobes = lobes | Lobe::kGlossy;
    }
    if (!any(lobes)) continue;
    Paths::Path path = paths.paths[k];
    const uint64_t own = hash_words(seed, path.index);
    const auto sample = bsdf.sample(si, lobes, random_float(own, kLobe),
                                    {random_float(own, kLobeX), random_float(own, kLobeY)});
    if (!sample) continue;
    Rgb weight = sample->weight;
    if (!any(sample->lobe & Lobe::kDelta)) {
      SurfaceInteraction seen = si;
      seen.wi = sample->wo;
      weight = bsdf.eval_pdf(seen, lobes, si.wi).f / sample->pdf;
    }
    const Vec3 to = si.frame.to_world(sample->wo);
    path.power *= weight * adjoint_factor(si, si.frame.to_world(si.wi), to);
    if (is_black(path.power)) continue;
    paths.paths[count] = path;
    paths.rays[count++] = {si.shadow_ray(to, kInfinity), Hit{}};
  }
  paths.paths.resize(count);
  paths.rays.resize(count);
}

void Caustics::connect(uint64_t seed, Paths& paths) const {
  constexpr Lobe kSeen = Lobe::kDiffuse | Lobe::kGlossy;
  for (size_t k = 0; k < paths.paths.size(); ++k) {
    if (!paths.rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(paths.rays[k]);
    const Bsdf& bsdf = si.shape->bsdf();
    if (!any(bsdf.lobes() & kSeen)) continue;
    const Paths::Path& path = paths.paths[k];
    const uint64_t own = hash_words(seed, path.index);
    const auto connection =
        sensor_.connect(si.p, {random_float(own, kLensX), random_float(own, kLensY)});
    if (!connection) continue;
    SurfaceInteraction seen = si;
    seen.wi = si.frame.to_local(connection->d);
    const Rgb f = bsdf.eval_pdf(seen, kSeen, si.wi).f;
    if (is_black(f)) continue;
    const float factor = adjoint_factor(si, si.frame.to_world(si.wi), connection->d);
    paths.shadow_rays.push_back(si.shadow_ray(connection->d, connection->distance));
    paths.splats.push_back(
        {connection->film_position, path.power * f * (factor * connection->weight)});
  }
}

void Caustics::trace(uint64_t seed, uint32_t count, FilmTile& film,
                     RenderCounters& counters) const {
  const StageTimer timer(counters.stage_seconds["caustics"]);
  Paths paths;
  for (uint32_t first = 0; first < count; first += kBatch) {
    emit(seed, first, std::min(first + kBatch, count), paths);
    for (const auto step : {&Caustics::reflect, &Caustics::connect}) {
      scene_.intersect(paths.rays, Coherence::kIncoherent, counters);
      counters[RayKind::kLight] += paths.rays.size();
      (this->*step)(seed, paths);
    }
    scene_.occluded(paths.shadow_rays, Coherence::kIncoherent, counters);
    counters[RayKind::kShadow] += paths.shadow_rays.size();
    for (size_t k = 0; k < paths.splats.size(); ++k) {
      if (paths.shadow_rays[k].is_occluded()) continue;
      film.add_splat(paths.splats[k].position, paths.splats[k].value);
    }
    paths.paths.clear();
    paths.rays.clear();
    paths.shadow_rays.clear();
    paths.splats.clear();
  }
  film.add_light_paths(count);
}

}  // namespace kinome

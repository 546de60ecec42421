#include "clustered/product/caustics.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/light_point_draw.h"
#include "clustered/product/spread.h"
#include "kinome/primary_rays.h"
#include "transport/adjoint.h"

namespace kinome {
namespace {

/// Paths of one call to Embree.
constexpr uint32_t kBatch = 1024;
/// Random numbers of one path, beside those of its lamp.
enum Number : uint32_t { kLobe, kLobeX, kLobeY, kLensX, kLensY };
/// Of the paths that only teach: half as many as there are light points, which go with the budget.
constexpr uint32_t kLeastPathsOfRound = 512, kMostPathsOfRound = 8192;
/// By which rays a path are counted.
constexpr uint32_t kPathsToCount = 512;
enum Seed : uint64_t { kSeedOfRounds = 0x6361756c };

}  // namespace

/// On their way.
struct Caustics::Paths {
  struct Path {
    uint32_t index = 0;
    LightOrigin origin;
    Rgb power{0.f};  ///< that arrives at the next point [W]
  };
  std::vector<Path> paths;
  std::vector<RayHit> rays;  ///< of each path, to its next point
  std::vector<Ray> shadow_rays;
  std::vector<LightGuide::Use> reflected;  ///< [W], of those that a mirror has sent on
  struct Splat {
    Vec2 position;
    Rgb value;
    LightGuide::Use use;  ///< [W], where it starts from
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

Caustics::Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light, uint64_t seed,
                   RenderCounters& counters)
    : scene_(scene), sensor_(sensor), light_(light), shares_(light.lamp_shares()) {
  double end = 0;
  for (const float share : shares_) ends_.push_back(end += static_cast<double>(share));
  const uint32_t paths_of_round =
      std::clamp(light.points_of_pass() / 2, kLeastPathsOfRound, kMostPathsOfRound);
  // First to mirrors, then to where these send light that is seen.
  for (const bool to_mirrors : {true, false}) {
    std::vector<LightGuide::Use> uses;
    trace_paths(hash_words(seed, kSeedOfRounds, to_mirrors), paths_of_round, counters,
                [&](const Paths& paths) {
                  if (to_mirrors) {
                    uses.insert(uses.end(), paths.reflected.begin(), paths.reflected.end());
                    return;
                  }
                  for (size_t k = 0; k < paths.splats.size(); ++k) {
                    if (!paths.shadow_rays[k].is_occluded()) uses.push_back(paths.splats[k].use);
                  }
                });
    if (uses.empty()) break;
    guide_ = LightGuide(shares_, uses, paths_of_round);
    if (!guide_.empty()) ends_ = guide_.ends();
  }
  const auto rays = [&] { return counters[RayKind::kLight] + counters[RayKind::kShadow]; };
  const auto before = rays();
  trace_paths(hash_words(seed, kSeedOfRounds, 2), kPathsToCount, counters, [](const Paths&) {});
  rays_per_path_ = static_cast<double>(rays() - before) / kPathsToCount;
}

/// From where the rays meet what mirrors; other paths end.
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
    const auto sample =
        transport::sample_adjoint(si, lobes, random_float(own, kLobe),
                                  {random_float(own, kLobeX), random_float(own, kLobeY)});
    if (!sample) continue;
    path.power *= sample->weight;
    if (is_black(path.power)) continue;
    paths.reflected.push_back({path.origin.source, path.origin.numbers, mean_of(path.power)});
    paths.paths[count] = path;
    paths.rays[count++] = {si.shadow_ray(sample->to, kInfinity), Hit{}};
  }
  paths.paths.resize(count);
  paths.rays.resize(count);
}

void Caustics::connect(uint64_t seed, Paths& paths) const {
  for (size_t k = 0; k < paths.paths.size(); ++k) {
    if (!paths.rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(paths.rays[k]);
    const Paths::Path& path = paths.paths[k];
    const uint64_t own = hash_words(seed, path.index);
    const auto seen = transport::connect_point(
        sensor_, si, {random_float(own, kLensX), random_float(own, kLensY)});
    if (!seen || is_black(seen->factor)) continue;
    paths.shadow_rays.push_back(seen->shadow_ray);
    paths.splats.push_back({seen->film_position,
                            path.power * seen->factor,
                            {path.origin.source, path.origin.numbers, mean_of(path.power)}});
  }
}

template <class Function>
void Caustics::trace_paths(uint64_t seed, uint32_t count, RenderCounters& counters,
                           const Function& fn) const {
  Paths paths;
  const Turns turns(ends_, count, seed);
  for (uint32_t first = 0; first < count; first += kBatch) {
    for (uint32_t i = first; i < std::min(first + kBatch, count); ++i) {
      const Turns::Turn turn = turns[i];
      LightOrigin origin =
          LightNumbers(hash_words(seed, turn.source)).origin(turn.source, turn.number);
      origin.guided = guide_.warp(turn.source, origin.numbers);
      const auto sample =
          light_.emitter(turn.source).sample_emission(origin.position(), origin.direction());
      if (!sample || is_black(sample->power)) continue;
      const float density = shares_[turn.source] * origin.guided;
      paths.paths.push_back({i, origin, sample->power / density});
      paths.rays.push_back({sample->ray(), Hit{}});
    }
    for (const auto step : {&Caustics::reflect, &Caustics::connect}) {
      scene_.intersect(paths.rays, Coherence::kIncoherent, counters);
      counters[RayKind::kLight] += paths.rays.size();
      (this->*step)(seed, paths);
    }
    scene_.occluded(paths.shadow_rays, Coherence::kIncoherent, counters);
    counters[RayKind::kShadow] += paths.shadow_rays.size();
    fn(paths);
    paths.paths.clear();
    paths.rays.clear();
    paths.reflected.clear();
    paths.shadow_rays.clear();
    paths.splats.clear();
  }
}

void Caustics::trace(uint64_t seed, uint32_t count, FilmTile& film,
                     RenderCounters& counters) const {
  const StageTimer timer(counters.stage_seconds["caustics"]);
  trace_paths(seed, count, counters, [&](const Paths& paths) {
    for (size_t k = 0; k < paths.splats.size(); ++k) {
      if (paths.shadow_rays[k].is_occluded()) continue;
      film.add_splat(paths.splats[k].position, paths.splats[k].value);
    }
  });
  film.add_light_paths(count);
}

}  // namespace kinome

#include "clustered/product/paths/caustics.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/tiles/primaries.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/primary_rays.h"
#include "transport/light_paths/adjoint.h"

namespace kinome {
namespace {

/// Paths of one call to Embree.
constexpr uint32_t kBatch = 1024;
/// Random numbers of one path, in addition to those of its source.
enum CausticNumber : uint32_t { kLobe, kLobeX, kLobeY, kLensX, kLensY, kCausticSurvival };
/// Bounds of the number of paths of a learning round. It is half the number of light points, which
/// depends on the budget.
constexpr uint32_t kMinPathsPerRound = 512, kMaxPathsPerRound = 8192;
/// Maximum number of paths for estimates of the rays per path and of shares.
constexpr uint32_t kMaxPathsToEstimate = 2048;
/// Number of learning rounds. The first learns which light reaches mirrors; the others learn which
/// of their light is seen.
constexpr uint64_t kRounds = 3;
/// Assumed number of paths per primary. Both depend on the budget.
constexpr double kPathsPerPrimary = 0.5;
/// Light of emitting surfaces and the sky is left to EyeChains if the balance weight of paths from
/// the emitters is below this value on average. This is so for large emitters.
constexpr double kMinLightShare = 0.7;
/// Maximum survival probability of roulette, so that chains of lossless mirrors end.
constexpr float kMaxSurvival = 0.95f;
enum Seed : uint64_t { kSeedOfRounds = 0x6361756c };

}  // namespace

/// Paths that are being traced.
struct Caustics::Paths {
  struct Path {
    uint32_t index = 0;
    LightOrigin origin;
    Rgb power{0.f};  ///< that arrives at the next point [W]
    bool is_lamps = false;
    bool is_direct = true;     ///< no lobe has turned it; see LocalLight::passing
    bool is_chain = true;      ///< delta lobes alone have turned it
    bool is_mirrored = false;  ///< the last lobe was a delta lobe, or the light is a lamp's
    float density = 0;         ///< light_density()
    uint32_t edges = 1;        ///< including the current one
  };
  std::vector<Path> paths;
  std::vector<RayHit> rays;  ///< next edge of each path
  std::vector<Ray> shadow_rays;
  std::vector<LightGuide::Use> reflected;  ///< [W], paths that a mirror has sent on
  struct Splat {
    Vec2 position;
    Rgb value;
    LightGuide::Use use;  ///< [W], source and random numbers of the path
    float guided;         ///< LightOrigin::guided
    float share;          ///< balance weight, already a factor of `value`
    bool is_chain;        ///< Path::is_chain
  };
  std::vector<Splat> splats;  ///< contributions if the shadow rays are unoccluded
};

bool Caustics::serves(const Sensor& sensor) {
  const Rect& crop = sensor.film().crop();
  const Vec2 centre(0.5f * static_cast<float>(crop.x0 + crop.x1),
                    0.5f * static_cast<float>(crop.y0 + crop.y1));
  const Ray ray = sensor.sample_ray(centre, Vec2(0.5f));
  const float t = std::min(std::max(1.f, 2 * ray.tmin), 0.5f * (ray.tmin + ray.tmax));
  return sensor.connect(ray.o + ray.d * t, Vec2(0.5f)).has_value();
}

Caustics::Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light,
                   bool hides_environment, uint64_t seed, RenderCounters& counters)
    : scene_(scene),
      sensor_(sensor),
      light_(light),
      hides_environment_(hides_environment),
      paths_of_round_(std::clamp(light.points_of_pass() / 2, kMinPathsPerRound, kMaxPathsPerRound)),
      paths_to_estimate_(std::min(paths_of_round_, kMaxPathsToEstimate)),
      finds_extended_(light.has_extended_caustics()) {
  learn(hash_words(seed, kSeedOfRounds), counters);
  if (finds_extended_ && !is_worth_finding(hash_words(seed, kSeedOfRounds, 1), counters)) {
    finds_extended_ = false;
    rates_.clear();
    if (light.has_lamp_caustics()) learn(hash_words(seed, kSeedOfRounds, 2), counters);
  }
}

/// Traces `count` paths and calls fn(splat) for each unoccluded splat.
template <class Function>
void Caustics::for_each_splat(uint64_t seed, uint32_t count, RenderCounters& counters,
                              const Function& fn) const {
  trace_paths(seed, count, counters, [&](const Paths& paths) {
    for (size_t k = 0; k < paths.splats.size(); ++k) {
      if (!paths.shadow_rays[k].is_occluded()) fn(paths.splats[k]);
    }
  });
}

/// Learns shares, guide and rates, and measures the rays per path.
void Caustics::learn(uint64_t seed, RenderCounters& counters) {
  shares_ = light_.caustic_shares(finds_extended_);
  ends_.clear();
  double end = 0;
  for (const float share : shares_) ends_.push_back(end += static_cast<double>(share));
  guide_ = {};
  for (uint64_t round = 0; round < kRounds; ++round) {
    std::vector<LightGuide::Use> uses;
    const uint64_t own = hash_words(seed, round);
    if (round == 0) {
      trace_paths(own, paths_of_round_, counters, [&](const Paths& paths) {
        uses.insert(uses.end(), paths.reflected.begin(), paths.reflected.end());
      });
    } else {
      for_each_splat(own, paths_of_round_, counters,
                     [&](const Paths::Splat& splat) { uses.push_back(splat.use); });
    }
    if (uses.empty()) break;
    guide_ = LightGuide(shares_, uses, paths_of_round_);
    if (!guide_.empty()) ends_ = guide_.ends();
  }
  const auto rays = [&] { return counters[RayKind::kLight] + counters[RayKind::kShadow]; };
  const auto before = rays();
  std::vector<double> used(shares_.size()), unguided(shares_.size());
  for_each_splat(hash_words(seed, kRounds), paths_to_estimate_, counters,
                 [&](const Paths::Splat& splat) {
                   used[splat.use.source] += static_cast<double>(splat.use.use);
                   unguided[splat.use.source] += static_cast<double>(splat.use.use / splat.guided);
                 });
  rays_per_path_ = static_cast<double>(rays() - before) / paths_to_estimate_;
  const double pixels = sensor_.film().crop().area();
  for (size_t s = 0; s < shares_.size(); ++s) {
    const double gain = unguided[s] > 0 ? used[s] / unguided[s] : 1.;
    rates_.push_back(static_cast<float>(shares_[s] * kPathsPerPrimary * pixels * gain));
  }
}

/// Returns true if paths from the emitters find enough of the light of emitting surfaces and the
/// sky; see kMinLightShare.
bool Caustics::is_worth_finding(uint64_t seed, RenderCounters& counters) const {
  double all = 0, by_light = 0;
  for_each_splat(seed, paths_to_estimate_, counters, [&](const Paths::Splat& splat) {
    if (light_.is_lamp(splat.use.source) || !splat.is_chain) return;
    const auto value = static_cast<double>(mean_of(splat.value));
    all += value / static_cast<double>(splat.share);
    by_light += value;
  });
  return by_light > kMinLightShare * all;
}

float Caustics::eye_density(const SurfaceInteraction& x, const Vec3& d) const {
  if (!finds_extended_) return kInfinity;
  // The position on the lens is fixed, because the rays of a pixel cover the whole lens.
  const auto connection = sensor_.connect(x.p, Vec2(0.5f));
  if (!connection) return kInfinity;
  SurfaceInteraction seen = x;
  seen.wi = x.frame.to_local(connection->d);
  const float pdf =
      x.shape->bsdf().eval_pdf(seen, Lobe::kDiffuse | Lobe::kGlossy, x.frame.to_local(d)).pdf;
  const float primaries = connection->weight * std::abs(glm::dot(x.n, connection->d));
  const float density = primaries * pdf / std::abs(glm::dot(x.n, d));
  return density >= 0 ? density : kInfinity;
}

float Caustics::light_density(const Emitter& emitter, const SurfaceInteraction* x,
                              const Vec3& d) const {
  const float rate = rates_.empty() ? 1 : rates_[light_.source_of(emitter)];
  if (x) {
    const float cosine = std::abs(glm::dot(x->n, d));
    return rate * surface_emission_pdf(*x, d) / (emitter.shape()->area() * cosine);
  }
  const auto density = emitter.emission_density(d);
  return density ? rate * density->direction * density->position : 0;
}

float Caustics::share_of_eye(float eye_density, float light_density) {
  if (!std::isfinite(eye_density)) return 1;
  if (!(light_density < kInfinity)) return 0;
  return light_density > 0 ? eye_density / (eye_density + light_density) : 1.f;
}

/// Samples the next edge of each path. Paths of lamps continue only from the first surface, if it
/// mirrors. Paths of other sources continue by a delta lobe first, then by any lobe.
void Caustics::go_on(uint64_t seed, Paths& paths) const {
  size_t count = 0;
  for (size_t k = 0; k < paths.paths.size(); ++k) {
    Paths::Path path = paths.paths[k];
    // The path will have two more edges: the next one and that to the camera.
    const bool may_go_on = path.is_lamps ? path.edges == 1 : path.edges + 2 <= light_.max_depth();
    if (!may_go_on || !paths.rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(paths.rays[k]);
    const Bsdf& bsdf = si.shape->bsdf();
    Lobe lobes = bsdf.lobes() & Lobe::kDelta;
    if (path.is_lamps && light_.has_glossy_caustics() && lobe_width(si) == LobeWidth::kMirroring) {
      lobes = lobes | Lobe::kGlossy;
    }
    if (!path.is_lamps && !path.is_direct) lobes = Lobe::kAll;
    if (!any(lobes)) continue;
    const uint64_t own = hash_words(seed, path.index, path.edges);
    const auto sample =
        transport::sample_adjoint(si, lobes, random_float(own, kLobe),
                                  {random_float(own, kLobeX), random_float(own, kLobeY)});
    if (!sample || is_black(sample->weight)) continue;
    const bool passes = sample->is_straight && !path.is_lamps && light_.passing();
    const bool is_first = path.is_direct && !passes;
    if (!passes) {
      path.is_direct = false;
      path.is_mirrored = sample->is_delta || path.is_lamps;
      path.is_chain = path.is_chain && path.is_mirrored;
    }
    if (!path.is_chain || path.edges >= std::min(light_.length().rr_depth, kMaxSureEdges)) {
      const float survival = std::min(
          kMaxSurvival, max_component(path.power * sample->weight) / max_component(path.power));
      if (!(random_float(own, kCausticSurvival) < survival)) continue;
      path.power /= survival;
    }
    path.power *= sample->weight;
    if (is_first) {
      paths.reflected.push_back({path.origin.source, path.origin.numbers, mean_of(path.power)});
    }
    ++path.edges;
    paths.paths[count] = path;
    paths.rays[count++] = {si.shadow_ray(sample->to, kInfinity), Hit{}};
  }
  paths.paths.resize(count);
  paths.rays.resize(count);
}

/// Connects the paths that came by a mirror to the sensor.
void Caustics::connect(uint64_t seed, Paths& paths) const {
  for (size_t k = 0; k < paths.paths.size(); ++k) {
    const Paths::Path& path = paths.paths[k];
    if (!path.is_mirrored || !paths.rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(paths.rays[k]);
    const uint64_t own = hash_words(seed, path.index, path.edges);
    const auto seen = transport::connect_point(
        sensor_, si, {random_float(own, kLensX), random_float(own, kLensY)});
    if (!seen || is_black(seen->factor)) continue;
    float share = 1;
    if (!path.is_lamps) {
      const Bsdf& bsdf = si.shape->bsdf();
      SurfaceInteraction viewed = si;
      viewed.wi = si.frame.to_local(seen->shadow_ray.d);
      if (goes_on_as_path(bsdf, bsdf.reflection_frame(viewed).n, seen->shadow_ray.d,
                          hides_environment_)) {
        continue;
      }
      const float density = eye_density(si, si.frame.to_world(si.wi));
      if (!(density < kInfinity)) continue;
      if (path.is_chain) share -= share_of_eye(density, path.density);
    }
    if (!(share > 0)) continue;
    const float use = share * mean_of(path.power);
    paths.shadow_rays.push_back(seen->shadow_ray);
    paths.splats.push_back({seen->film_position,
                            path.power * seen->factor * share,
                            {path.origin.source, path.origin.numbers, use},
                            path.origin.guided,
                            share,
                            path.is_chain});
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
      const Emitter& emitter = light_.emitter(turn.source);
      const auto leaving = leave_light(emitter, origin.position(), origin.direction());
      if (!leaving || is_black(leaving->sample.power)) continue;
      const float probability = shares_[turn.source] * origin.guided;
      Paths::Path path{i, origin, leaving->sample.power / probability};
      path.is_lamps = light_.is_lamp(turn.source);
      if (!path.is_lamps) {
        path.density =
            light_density(emitter, leaving->x ? &*leaving->x : nullptr, leaving->sample.d);
      }
      paths.paths.push_back(path);
      paths.rays.push_back({leaving->sample.ray(), Hit{}});
    }
    while (!paths.rays.empty()) {
      scene_.intersect(paths.rays, Coherence::kIncoherent, counters);
      counters[RayKind::kLight] += paths.rays.size();
      connect(seed, paths);
      go_on(seed, paths);
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

std::vector<float> Caustics::variance(uint64_t seed, uint32_t tried, double count,
                                      const TileGrid& grid, RenderCounters& counters) const {
  std::vector<float> squares(static_cast<size_t>(grid.crop().area()));
  const auto scale = static_cast<float>(1 / (tried * std::max(count, 1.)));
  const Rect& crop = grid.crop();
  for_each_splat(seed, tried, counters, [&](const Paths::Splat& splat) {
    const auto x = static_cast<int>(std::floor(splat.position.x));
    const auto y = static_cast<int>(std::floor(splat.position.y));
    if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1) return;
    squares[grid.pixel(x, y)] += scale * glm::dot(splat.value, splat.value) * (1 / 3.f);
  });
  return squares;
}

void Caustics::trace(uint64_t seed, uint32_t count, FilmTile& film,
                     RenderCounters& counters) const {
  const StageTimer timer(counters.stage_seconds["caustics"]);
  for_each_splat(seed, count, counters,
                 [&](const Paths::Splat& splat) { film.add_splat(splat.position, splat.value); });
  film.add_light_paths(count);
}

}  // namespace kinome

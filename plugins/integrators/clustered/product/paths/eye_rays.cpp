#include "clustered/product/paths/eye_rays.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/paths/caustics.h"
#include "clustered/product/paths/mirrored_direction.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

/// Random numbers of one primary's eye ray.
constexpr uint32_t kNumbers = 4;
/// Random numbers at the hit of an eye ray.
enum MetNumber : uint32_t {
  kArrival = 0,
  kFollow = 3,
  kGoOn = 6,
  kSurvival = 9,
  kPath = 10,
  kPoint = 11,
  kChain = 12,
  kBehind = 13  ///< seed for the hit behind a surface that the eye ray passes
};
/// Number of edges from the camera to the point where paths continue.
constexpr uint32_t kEdgesBefore = 2;
/// Random number derived from a tile's seed.
constexpr uint32_t kTileBlock = 7;
/// Throughput from which paths always survive roulette.
constexpr float kMinSureThroughput = 0.5f;

/// Returns the balance weight of one of three techniques. Their densities are in the ratio
/// 1 / odds : 1 : follow_ratio, for light points, for eye rays with a sampled emitter, and for eye
/// rays that continue by a lobe. `own` is the value of the technique in this ratio. `odds` is
/// infinity if there are no light points.
float share_of(float own, float follow_ratio, float odds) {
  if (odds == 0) return 0;
  if (!std::isfinite(own)) return 1;
  // Odds that aren't above 0 are due to overflow (NaN): the light point is too near.
  return own / (1 + follow_ratio + (odds > 0 ? 1 / odds : 0));
}

}  // namespace

void EyeRays::begin_tile(const Scene& scene, const LocalChoice& choice, uint64_t seed,
                         RenderCounters& counters) {
  scene_ = &scene;
  counters_ = &counters;
  if (!paths_ && light_.local->max_depth() > kEdgesBefore + 1) {
    paths_.emplace(scene, PathSettings{light_.local->length(), false}, kEdgesBefore,
                   light_.local, light_.groups);
  }
  if (rays_.empty()) {
    tiles_.clear();
    rates_.clear();
    points_.clear();
  }
  Tile tile{rates_.size(), {}};
  rates_.insert(rates_.end(), choice.rates().begin(), choice.rates().end());
  if (paths_) tile.points = points_.take(choice, random_bits(seed, kTileBlock), kEdgesBefore + 1);
  tiles_.push_back(tile);
}

bool EyeRays::applies(const GroupView& group) const {
  return (light_.local->has_surfaces() || light_.local->has_bounce()) &&
         group.has(Lobe::kDiffuse | Lobe::kGlossy);
}

/// Draws directions of the chosen members. The padding repeats the last member.
void EyeRays::draw(const GroupView& group, uint64_t seed) {
  Candidates& c = directions_;
  const size_t count = chosen_.size(), length = padded(count);
  numbers_[0].assign(length, 0);
  numbers_[1].assign(length, 0);
  c.resize(length);
  for (size_t k = 0; k < length; ++k) {
    c.member[k] = chosen_[std::min(k, count - 1)];
    const uint64_t own = hash_words(seed, group.primary(c.member[k]));
    for (uint32_t i = 0; i < 2; ++i) numbers_[i][k] = random_bits(own, 1 + i);
  }
  const float share = diffuse_share(group.patch);
  simd::sample_lobe(group.patch.lobe, group.points(), c.member.data(),
                    {numbers_[0].data(), numbers_[1].data(), {0, 0}}, length, c.dx.data(),
                    c.dy.data(), c.dz.data());
  for (size_t k = 0; k < count; ++k) {
    const uint32_t primary = group.primary(c.member[k]);
    if (random_float(hash_words(seed, primary), 3) >= share) continue;
    const Vec3 d = Frame::from_normal(group.primaries.normal(primary))
                       .to_world(square_to_cosine_hemisphere(
                           {to_unit_float(numbers_[0][k]), to_unit_float(numbers_[1][k])}));
    c.dx[k] = d.x;
    c.dy[k] = d.y;
    c.dz[k] = d.z;
  }
}

void EyeRays::send(const GroupView& group, float expected, uint64_t seed,
                   const UnitSums& sums) {
  chosen_.clear();
  for (uint32_t j = 0; j < group.group.count; ++j) {
    const uint64_t own = hash_words(seed, group.primary(j));
    if (random_float(own, 0) < expected) chosen_.push_back(j);
  }
  if (chosen_.empty()) return;
  draw(group, seed);
  Candidates& c = directions_;
  values_.all(group, c.directions(0), c.lobe_columns(0));
  for (size_t k = 0; k < chosen_.size(); ++k) {
    const float density = expected * c.lobe_density[k];
    const Rgb weight = c.f_of(k) / density;
    if (!(density > 0) || is_black(weight)) continue;
    const uint32_t primary = group.primary(c.member[k]);
    const Ray ray = group.primaries.place(primary).spawn_ray(c.direction(k));
    const float chain_density =
        light_.caustics ? light_.caustics->eye_density(group.primaries.interaction(primary), ray.d)
                        : kInfinity;
    push(ray, {weight, density, static_cast<uint32_t>(tiles_.size() - 1),
               hash_words(seed, primary, kNumbers), &sums.of(primary), chain_density});
  }
}

void EyeRays::send_mirrored(const SurfaceInteraction& si, uint32_t primary, uint64_t seed,
                            Rgb& sum) {
  const auto mirrored = mirrored_direction(si, primary, seed);
  if (!mirrored || is_black(mirrored->weight)) return;
  push(si.spawn_ray(mirrored->d),
       {mirrored->weight, 0, static_cast<uint32_t>(tiles_.size() - 1),
        hash_words(seed, primary, kNumbers), &sum});
}

void EyeRays::trace(ShadowRays& shadow_rays) {
  while (!rays_.empty()) {
    std::swap(hits_, traced_hits_);
    std::swap(rays_, traced_);
    for (size_t begin = 0; begin < traced_.size(); begin += kEyeRaysPerCall) {
      const size_t count = std::min(kEyeRaysPerCall, traced_.size() - begin);
      scene_->intersect({&traced_hits_[begin], count}, Coherence::kIncoherent, *counters_);
      (*counters_)[RayKind::kBsdf] += count;
      for (size_t i = begin; i < begin + count; ++i) {
        find_light(traced_hits_[i], traced_[i], shadow_rays);
      }
    }
    traced_hits_.clear();
    traced_.clear();
  }
  chains_.trace(*scene_, *counters_);
  if (paths_) paths_->trace(*counters_);
}

/// Returns the density of eye rays at a point that an eye ray found, relative to that of light
/// points.
float EyeRays::eye_odds(const EyeRay& eye, const SurfaceInteraction& y, const RayHit& ray,
                        const LocalLight::Place& place) const {
  if (eye.density == 0) return kInfinity;  // only a delta lobe finds the point
  const float geometry = std::abs(glm::dot(y.n, ray.ray.d)) / sqr(ray.ray.tmax);
  return eye.density * geometry * place.eye_ratio / rates_of(eye)[place.cell];
}

/// Continues an eye ray straight through the surface at y.
void EyeRays::pass(const RayHit& ray, const SurfaceInteraction& y, const EyeRay& eye) {
  if (max_passes(eye, kEdgesBefore) == 0) return;
  EyeRay next = eye;
  next.weight *= y.shape->bsdf().null_transmission(y).transmittance;
  if (is_black(next.weight)) return;
  ++next.passes;
  next.before = ray.ray.tmax;
  next.seed = hash_words(eye.seed, kBehind);
  push(y.spawn_ray(ray.ray.d), next);
}

/// Number of surfaces that light may still pass straight on its way to an eye ray's path. The path
/// has `edges` edges, and one more for each surface that the eye ray has passed.
uint32_t EyeRays::max_passes(const EyeRay& eye, uint32_t edges) const {
  return passes_left(light_.local->max_depth(), edges + eye.passes);
}

void EyeRays::find_light(const RayHit& met, const EyeRay& eye, ShadowRays& shadow_rays) {
  if (!met.hit.valid()) {
    // The cells of the sky account for its light, except for delta lobes.
    if (eye.density == 0 && light_.environment) {
      eye.sum[light_.sky_group] += eye.weight * light_.environment->eval_environment(met.ray.d);
    }
    return;
  }
  const LocalLight& local = *light_.local;
  const SurfaceInteraction y = scene_->interaction(met);
  RayHit ray = met;
  ray.ray.tmax += eye.before;
  if (light_.passing() && y.shape->bsdf().has_null_lobe()) pass(ray, y, eye);
  if (const Emitter* const emitter = y.shape->emitter()) {
    const Rgb radiance = emitter->eval_surface(y);
    if (!is_black(radiance)) {
      eye.sum[light_.group_of(emitter)] +=
          eye.weight * radiance * share_of(1, 0, eye_odds(eye, y, ray, local.surface_place(y)));
    }
  }
  if (local.max_depth() < LocalLight::kBounceDepth + eye.passes) return;
  const Bsdf& bsdf = y.shape->bsdf();
  const bool scatters = any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
  const bool matters = paths_ || local.has_extended() || local.has_glossy_caustics();
  const LobeWidth width = scatters && matters ? lobe_width(y) : LobeWidth::kWide;
  if (scatters) {
    find_arrival(ray, y, width, eye, shadow_rays);
    if (width != LobeWidth::kWide && local.has_extended()) follow(ray, y, width, eye);
  }
  if (any(bsdf.lobes() & Lobe::kDelta)) {
    chains_.push(y, {eye.weight, eye.chain_density, hash_words(eye.seed, kChain), eye.sum,
                     kEdgesBefore + eye.passes});
  }
  if (!paths_ || !any(bsdf.lobes())) return;
  if (scatters) connect_point(ray, y, width, eye, shadow_rays);
  go_on(ray, y, width, eye);
}

/// Makes a shadow ray from y, which an eye ray found, to a sampled source.
void EyeRays::find_arrival(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                           const EyeRay& eye, ShadowRays& shadow_rays) const {
  const auto arrival = light_.local->sample_arrival(
      y, random_float(eye.seed, kArrival),
      {random_float(eye.seed, kArrival + 1), random_float(eye.seed, kArrival + 2)});
  if (!arrival) return;
  const Bsdf& bsdf = y.shape->bsdf();
  const Vec3 wo = y.frame.to_local(arrival->d);
  // Light points represent reflected light alone.
  const bool is_through = wo.z * y.wi.z < 0;
  const float odds = is_through ? kInfinity : eye_odds(eye, y, ray, arrival->place);
  Rgb f(0.f);
  const bool is_lamp = arrival->density == 0;
  if (is_lamp && width == LobeWidth::kMirroring && light_.local->has_glossy_caustics() &&
      eye.density > 0) {
    // Paths from the lamp (Caustics) find the light of the glossy lobe.
    f = bsdf.eval_pdf(y, Lobe::kDiffuse, wo).f * share_of(1, 0, odds);
  } else if (width == LobeWidth::kWide || is_lamp) {
    f = bsdf.eval_pdf(y, Lobe::kDiffuse | Lobe::kGlossy, wo).f * share_of(1, 0, odds);
  } else {
    const BsdfValue glossy = bsdf.eval_pdf(y, Lobe::kGlossy, wo);
    const float follow_ratio = glossy.pdf / arrival->density;
    const bool is_mirroring = width == LobeWidth::kMirroring;
    f = bsdf.eval_pdf(y, Lobe::kDiffuse, wo).f *
            share_of(1, is_mirroring ? 0 : follow_ratio, odds) +
        glossy.f * share_of(1, follow_ratio, is_mirroring ? kInfinity : odds);
  }
  shadow_rays.push(y, arrival->d, arrival->distance,
                   {eye.weight * f * arrival->radiance, 0, -1, 0,
                    is_lamp ? 0 : max_passes(eye, kEdgesBefore + 1)},
                   {{eye.sum + light_.divided(arrival->group)}}, {});
}

/// Calls fn(Met) for each emitter that a ray from y hits. The ray passes at most `max_passes`
/// surfaces straight.
template <class Function>
void EyeRays::meet(const SurfaceInteraction& y, const Vec3& d, uint32_t max_passes,
                   const Function& fn) {
  Met met;
  Rgb transmittance(1.f);
  RayHit ray{y.spawn_ray(d), Hit{}};
  for (uint32_t passes = 0;; ++passes) {
    scene_->intersect({&ray, 1}, Coherence::kIncoherent, *counters_);
    ++(*counters_)[RayKind::kBsdf];
    if (!ray.hit.valid()) break;
    met.x = scene_->interaction(ray);
    met.distance += ray.ray.tmax;
    if (const Emitter* const emitter = met.x->shape->emitter()) {
      met.radiance = emitter->eval_surface(*met.x) * transmittance;
      if (!is_black(met.radiance)) fn(met);
    }
    const Bsdf& bsdf = met.x->shape->bsdf();
    if (!light_.passing() || !bsdf.has_null_lobe() || passes >= max_passes) return;
    transmittance *= bsdf.null_transmission(*met.x).transmittance;
    if (is_black(transmittance)) return;
    ray = {met.x->spawn_ray(d), Hit{}};
  }
  if (!light_.environment) return;
  met.x.reset();
  met.distance = kInfinity;
  met.radiance = light_.environment->eval_environment(d) * transmittance;
  if (!is_black(met.radiance)) fn(met);
}

/// Continues an eye ray by the glossy lobe at y, and adds the light of emitters that it hits.
void EyeRays::follow(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                     const EyeRay& eye) {
  const Vec2 u(random_float(eye.seed, kFollow), random_float(eye.seed, kFollow + 1));
  const Bsdf& bsdf = y.shape->bsdf();
  const auto sample = bsdf.sample(y, Lobe::kGlossy, random_float(eye.seed, kFollow + 2), u);
  if (!sample) return;
  // If light points find this light, too, the weight is for all lobes, like theirs.
  const bool is_shared = width == LobeWidth::kNarrow;
  Rgb weight = sample->weight;
  if (is_shared) weight += bsdf.eval_pdf(y, Lobe::kDiffuse, sample->wo).f / sample->pdf;
  if (is_black(weight)) return;
  const Vec3 d = y.frame.to_world(sample->wo);
  const bool is_through = sample->wo.z * y.wi.z < 0;
  meet(y, d, max_passes(eye, kEdgesBefore + 1), [&](const Met& met) {
    const LocalLight::Found found =
        light_.local->found_arrival(y, d, met.distance, met.x ? &*met.x : nullptr);
    const float ratio = sample->pdf / found.density;
    const float odds = is_shared && !is_through ? eye_odds(eye, y, ray, found.place) : kInfinity;
    eye.sum[light_.group_of(met.x ? met.x->shape->emitter() : light_.environment)] +=
        weight * share_of(ratio, ratio, odds) * eye.weight * met.radiance;
  });
}

/// Returns f, with which y sends light from wo to the eye, times the balance weight of eye rays.
/// `is_shown`: see LightPoint.
Rgb EyeRays::weighted_bsdf(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                           const Vec3& wo, const Rgb& f, const EyeRay& eye, bool is_shown) const {
  if (wo.z * y.wi.z < 0) return f;
  const Bsdf& bsdf = y.shape->bsdf();
  const float odds = eye_odds(eye, y, ray, light_.local->deep_place(y, wo.z));
  switch (width) {
    case LobeWidth::kWide:
      return f * share_of(1, 0, is_shown ? LocalLight::kShownEyeShare * odds : odds);
    case LobeWidth::kNarrow: {
      const float ratio = bsdf.eval_pdf(y, Lobe::kGlossy, wo).pdf / kDeepDensity;
      return f * share_of(1 + ratio, ratio, odds);
    }
    case LobeWidth::kMirroring:
      break;
  }
  // Light points represent the diffuse part alone.
  return f + bsdf.eval_pdf(y, Lobe::kDiffuse, wo).f * (share_of(1, 0, odds) - 1);
}

/// Returns weighted_bsdf() for light that delta lobes show, relative to its value for other light.
float EyeRays::shown_share(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                           const Vec3& wo, const EyeRay& eye) const {
  if (width != LobeWidth::kWide || wo.z * y.wi.z < 0) return 1;
  const float odds = eye_odds(eye, y, ray, light_.local->deep_place(y, wo.z));
  const float all = share_of(1, 0, odds);
  return all > 0 ? share_of(1, 0, LocalLight::kShownEyeShare * odds) / all : 1.f;
}

/// Continues an eye ray at y as a path. It finds light that reaches y by several edges;
/// connect_point() finds a part of it.
void EyeRays::go_on(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                    const EyeRay& eye) {
  const Vec2 u(random_float(eye.seed, kGoOn + 1), random_float(eye.seed, kGoOn + 2));
  const auto sample = y.shape->bsdf().sample(y, Lobe::kAll, random_float(eye.seed, kGoOn), u);
  // pass() follows straight transmission.
  if (!sample || (light_.passing() && any(sample->lobe & Lobe::kNull))) return;
  const bool is_delta = any(sample->lobe & Lobe::kDelta);
  Rgb throughput = eye.weight * sample->weight;
  if (!is_delta) {
    const Rgb f = sample->weight * sample->pdf;
    throughput = eye.weight * weighted_bsdf(ray, y, width, sample->wo, f, eye) / sample->pdf;
  }
  const float survival = std::min(1.f, max_component(glm::abs(throughput)) / kMinSureThroughput);
  if (!(random_float(eye.seed, kSurvival) < survival)) return;
  EyePaths::Begin begin;
  begin.ray = y.spawn_ray(y.frame.to_world(sample->wo));
  begin.throughput = throughput / survival;
  begin.density = is_delta ? kInfinity : sample->pdf;
  // EyeChains finds emitters seen through a chain that continues from a mirror.
  begin.shown_share_later = !is_delta ? shown_share(ray, y, width, sample->wo, eye)
                            : eye.chain_density < kInfinity ? 0
                                                            : 1;
  begin.shown_share = is_delta ? 0 : begin.shown_share_later;
  begin.rates = rates_of(eye);
  begin.seed = hash_words(eye.seed, kPath);
  begin.sum = eye.sum;
  begin.passes = eye.passes;
  paths_->push(begin);
}

/// Connects y to a light point with a shadow ray.
void EyeRays::connect_point(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                            const EyeRay& eye, ShadowRays& shadow_rays) {
  const std::span<const float> rates = rates_of(eye);
  const auto chosen =
      points_.choose(y, tiles_[eye.tile].points, random_float(eye.seed, kPoint));
  if (!chosen) return;
  const LightPoint& point = chosen->point;
  const uint32_t edges = kEdgesBefore + 1 + point.edges;
  if (edges + eye.passes > light_.local->max_depth()) return;
  const Vec3 to = point.position - y.p;
  const float distance = glm::length(to);
  const Vec3 d = to / distance, wo = y.frame.to_local(d);
  const BsdfValue value = y.shape->bsdf().eval_pdf(y, Lobe::kAll, wo);
  const float geometry = std::abs(glm::dot(point.geometric, d)) / sqr(distance);
  const float shown = point.is_shown ? LocalLight::kShownEyeShare : 1.f;
  const float odds = shown * value.pdf * geometry * points_.third_odds(point, rates);
  const Rgb power = point.reflection == LightPoint::kLambertian
                        ? point.power
                        : light_.local_points.reflections[point.reflection].toward(-d).radiance;
  const Rgb light = eye.weight * weighted_bsdf(ray, y, width, wo, value.f, eye, point.is_shown) *
                    power * (geometry * chosen->weight / ((1 + odds) * chosen->probability));
  if (is_black(light)) return;
  const Vec3 end = point.end_of_ray(d) - y.p;
  const float reach = glm::length(end);
  shadow_rays.push(y, end / std::max(reach, 1e-30f), reach,
                   {light, 0, -1, 0, max_passes(eye, edges)},
                   {{eye.sum + light_.divided(point.group)}}, {});
}

}  // namespace kinome

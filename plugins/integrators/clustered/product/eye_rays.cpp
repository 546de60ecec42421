// The part of Estimator that sends rays by the BSDFs of primaries: to local light that light points
// are too near to, and to what mirrors, and lobes too narrow for light points, show.
#include <algorithm>
#include <cmath>

#include "clustered/product/estimator.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

/// Rays of one call to Embree.
constexpr size_t kBatch = 1024;
/// Random numbers of one primary's eye ray.
constexpr uint32_t kNumbers = 4;

/// Share of one way to find light, by the balance heuristic. Light points find it, eye rays that a
/// drawn light is seen from, and eye rays that go on by a lobe: 1 / odds : 1 : follow_ratio; `own`
/// is that way's number. Infinite odds: there are no light points.
float share_of(float own, float follow_ratio, float odds) {
  if (odds == 0) return 0;
  if (!std::isfinite(own)) return 1;
  // Odds that have left the range of numbers, whichever way, mean a point that is too near.
  return own / (1 + follow_ratio + (odds > 0 ? 1 / odds : 0));
}

}  // namespace

/// Some members of the group send a ray; what it finds counts by the share of eye rays among all
/// that could have found it.
void Estimator::send_eye_rays(const Group& group, uint64_t seed, Rgb* sum) {
  const LocalLight& local = *light_.local;
  if (!local.has_surfaces() && !local.has_bounce()) return;
  const Patch& patch = (*patches_)[group.patch];
  if (!any(patch.bsdf->lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return;
  const StageScope timer(innermost_stage_, *stages_.candidates);
  const float expected = eye_rays_of(patch);
  chosen_.clear();
  for (uint32_t j = 0; j < group.count; ++j) {
    const uint64_t own = hash_words(seed, member_of(group, j));
    if (random_float(own, 0) < expected) chosen_.push_back(j);
  }
  if (chosen_.empty()) return;
  const size_t count = chosen_.size(), padded = simd::pad_lanes(count);
  numbers_[0].assign(padded, 0);
  numbers_[1].assign(padded, 0);
  Candidates& c = candidates_;
  const size_t first = c.size();
  c.resize(first + padded);
  for (size_t k = 0; k < padded; ++k) {
    c.member[first + k] = chosen_[std::min(k, count - 1)];
    const uint64_t own = hash_words(seed, member_of(group, c.member[first + k]));
    for (uint32_t i = 0; i < 2; ++i) numbers_[i][k] = random_bits(own, 1 + i);
  }
  const float share = diffuse_share(patch);
  simd::sample_lobe(patch.lobe, points_of(group), &c.member[first],
                    {numbers_[0].data(), numbers_[1].data(), {0, 0}}, padded, &c.dx[first],
                    &c.dy[first], &c.dz[first]);
  for (size_t k = 0; k < count; ++k) {
    const uint32_t primary = member_of(group, c.member[first + k]);
    if (random_float(hash_words(seed, primary), 3) >= share) continue;
    const Vec3 d = Frame::from_normal(primaries_->normal[primary])
                       .to_world(square_to_cosine_hemisphere(
                           {to_unit_float(numbers_[0][k]), to_unit_float(numbers_[1][k])}));
    c.dx[first + k] = d.x;
    c.dy[first + k] = d.y;
    c.dz[first + k] = d.z;
  }
  evaluate_all_lobes(group, first);
  for (size_t k = 0; k < count; ++k) {
    const size_t i = first + k;
    const float density = expected * c.lobe_density[i];
    const Rgb weight = Rgb(c.f[0][i], c.f[1][i], c.f[2][i]) / density;
    if (!(density > 0) || is_black(weight)) continue;
    const uint32_t primary = member_of(group, c.member[i]);
    const Vec3 d = c.direction(i);
    Ray ray;
    ray.o = primaries_->interaction(primary).ray_origin(d);
    ray.d = d;
    push_eye_ray(ray, {weight, density, tile_rates_, hash_words(seed, primary, kNumbers), sum});
  }
  c.resize(first);
}

/// Light that the delta lobes of a point mirror, and where from; nothing if they have no direction.
std::optional<Estimator::Mirrored> Estimator::mirror(uint32_t primary, uint64_t seed) const {
  const SurfaceInteraction& si = primaries_->interaction(primary);
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & Lobe::kDelta)) return std::nullopt;
  const Vec2 u(random_float(seed, 2 * primary), random_float(seed, 2 * primary + 1));
  const auto sample = bsdf.sample(si, Lobe::kDelta, 0.5f, u);
  if (!sample) return std::nullopt;
  const Vec3 d = si.frame.to_world(sample->wo);
  const Rgb radiance = light_.environment ? light_.environment->eval_environment(d) : Rgb(0.f);
  return Mirrored{d, sample->weight * radiance};
}

/// What the delta lobes of a primary mirror, all of it.
void Estimator::send_mirrored(uint32_t primary, uint64_t seed, Rgb* sum) {
  const SurfaceInteraction& si = primaries_->interaction(primary);
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & Lobe::kDelta)) return;
  const Vec2 u(random_float(seed, 2 * primary), random_float(seed, 2 * primary + 1));
  const auto sample = bsdf.sample(si, Lobe::kDelta, 0.5f, u);
  if (!sample || is_black(sample->weight)) return;
  Ray ray;
  ray.d = si.frame.to_world(sample->wo);
  ray.o = si.ray_origin(ray.d);
  push_eye_ray(ray, {sample->weight, 0, tile_rates_, hash_words(seed, primary, kNumbers), sum});
}

void Estimator::push_eye_ray(const Ray& ray, const EyeRay& eye) {
  eye_hits_.push_back({ray, Hit{}});
  eye_rays_.push_back(eye);
}

void Estimator::trace_eye_rays() {
  if (eye_rays_.empty()) return;
  const StageScope timer(innermost_stage_, *stages_.eye);
  for (size_t begin = 0; begin < eye_rays_.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, eye_rays_.size() - begin);
    scene_->intersect({&eye_hits_[begin], count}, Coherence::kIncoherent, *counters_);
    (*counters_)[RayKind::kBsdf] += count;
    for (size_t i = begin; i < begin + count; ++i) find_light(eye_hits_[i], eye_rays_[i]);
  }
  eye_hits_.clear();
  eye_rays_.clear();
}

/// Of a place that an eye ray found: how many such rays there are to one light point.
float Estimator::eye_odds(const EyeRay& eye, const SurfaceInteraction& y, const RayHit& ray,
                          const LocalLight::Place& place) const {
  if (eye.density == 0) return kInfinity;  // of a delta lobe: nothing else finds it
  const float geometry = std::abs(glm::dot(y.n, ray.ray.d)) / sqr(ray.ray.tmax);
  return eye.density * geometry * place.eye_ratio / eye_rates_[eye.rates + place.cell];
}

void Estimator::find_light(const RayHit& ray, const EyeRay& eye) {
  if (!ray.hit.valid()) {
    // Others leave the sky to its own cells.
    if (eye.density == 0 && light_.environment) {
      *eye.sum += eye.weight * light_.environment->eval_environment(ray.ray.d);
    }
    return;
  }
  const LocalLight& local = *light_.local;
  const SurfaceInteraction y = scene_->interaction(ray);
  if (const Emitter* const emitter = y.shape->emitter()) {
    const Rgb radiance = emitter->eval_surface(y);
    if (!is_black(radiance)) {
      *eye.sum +=
          eye.weight * radiance * share_of(1, 0, eye_odds(eye, y, ray, local.surface_place(y)));
    }
  }
  if (local.max_depth() < LocalLight::kBounceDepth) return;
  const Bsdf& bsdf = y.shape->bsdf();
  if (any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
    const bool matters = local.has_extended() || local.has_glossy_caustics();
    const LobeWidth width = matters ? lobe_width(y) : LobeWidth::kWide;
    find_arrival(ray, y, width, eye);
    if (width != LobeWidth::kWide && local.has_extended()) follow(ray, y, width, eye);
  }
  if (any(bsdf.lobes() & Lobe::kDelta)) look_behind(y, eye);
}

/// Light at a place that an eye ray found, from a source that is chosen.
void Estimator::find_arrival(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                             const EyeRay& eye) {
  const auto arrival = light_.local->sample_arrival(
      y, random_float(eye.seed, 0), {random_float(eye.seed, 1), random_float(eye.seed, 2)});
  if (!arrival) return;
  const Bsdf& bsdf = y.shape->bsdf();
  const Vec3 wo = y.frame.to_local(arrival->d);
  const float odds = eye_odds(eye, y, ray, arrival->place);
  Rgb f(0.f);
  const bool is_lamp = arrival->density == 0;
  if (is_lamp && width == LobeWidth::kMirroring && light_.local->has_glossy_caustics() &&
      eye.density > 0) {
    // Paths from the lamp (Caustics) have the rest, but for what delta lobes see.
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
  push_shadow_ray(y.shadow_ray(arrival->d, arrival->distance), eye.weight * f * arrival->radiance,
                  0, -1, eye.sum);
}

/// What a ray from a surface meets.
std::optional<Estimator::Met> Estimator::meet(const SurfaceInteraction& y, const Vec3& wo) {
  Met met;
  met.ray.ray.d = y.frame.to_world(wo);
  met.ray.ray.o = y.ray_origin(met.ray.ray.d);
  scene_->intersect({&met.ray, 1}, Coherence::kIncoherent, *counters_);
  ++(*counters_)[RayKind::kBsdf];
  if (!met.ray.hit.valid()) {
    if (light_.environment) met.radiance = light_.environment->eval_environment(met.ray.ray.d);
  } else {
    met.x = scene_->interaction(met.ray);
    if (const Emitter* const emitter = met.x->shape->emitter()) {
      met.radiance = emitter->eval_surface(*met.x);
    }
  }
  if (is_black(met.radiance)) return std::nullopt;
  return met;
}

/// Light that a narrow lobe shows to where an eye ray comes from.
void Estimator::follow(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                       const EyeRay& eye) {
  const Vec2 u(random_float(eye.seed, 3), random_float(eye.seed, 4));
  const Bsdf& bsdf = y.shape->bsdf();
  const auto sample = bsdf.sample(y, Lobe::kGlossy, 0.5f, u);
  if (!sample) return;
  // Where light points have a part, shares are of what all lobes send on, as theirs are.
  const bool is_shared = width == LobeWidth::kNarrow;
  Rgb weight = sample->weight;
  if (is_shared) weight += bsdf.eval_pdf(y, Lobe::kDiffuse, sample->wo).f / sample->pdf;
  if (is_black(weight)) return;
  const auto met = meet(y, sample->wo);
  if (!met) return;
  const LocalLight::Found found = light_.local->found_arrival(y, met->ray.ray.d, met->ray.ray.tmax,
                                                              met->x ? &*met->x : nullptr);
  const float ratio = sample->pdf / found.density;
  const float odds = is_shared ? eye_odds(eye, y, ray, found.place) : kInfinity;
  *eye.sum += weight * share_of(ratio, ratio, odds) * eye.weight * met->radiance;
}

/// Light that a mirror shows to where an eye ray comes from: no light point is on a mirror.
void Estimator::look_behind(const SurfaceInteraction& y, const EyeRay& eye) {
  const Vec2 u(random_float(eye.seed, 3), random_float(eye.seed, 4));
  const auto sample = y.shape->bsdf().sample(y, Lobe::kDelta, 0.5f, u);
  if (!sample || is_black(sample->weight)) return;
  if (const auto met = meet(y, sample->wo)) *eye.sum += eye.weight * sample->weight * met->radiance;
}

}  // namespace kinome

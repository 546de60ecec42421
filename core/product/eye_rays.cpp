// The part of Estimator that sends rays by the BSDFs of primaries: to local light that light points
// are too near to, and to what mirrors show.
#include <algorithm>
#include <cmath>

#include "estimator.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

/// Rays of one call to Embree.
constexpr size_t kBatch = 1024;
/// Random numbers of one primary's eye ray.
constexpr uint32_t kNumbers = 4;

}  // namespace

/// Some members of the group send a ray; what it finds counts by the share of eye rays among all
/// that could have found it.
void Estimator::send_eye_rays(const Group& group, uint64_t seed, Rgb* sum) {
  const LocalLight& local = *light_.local;
  if (!local.has_surfaces() && !local.has_bounce()) return;
  const Patch& patch = (*patches_)[group.patch];
  if (!any(patch.bsdf->lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return;
  const StageTimer timer(*stages_.candidates);
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
  const StageTimer timer(*stages_.eye);
  for (size_t begin = 0; begin < eye_rays_.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, eye_rays_.size() - begin);
    scene_->intersect({&eye_hits_[begin], count}, Coherence::kIncoherent, *counters_);
    (*counters_)[RayKind::kBsdf] += count;
    for (size_t i = begin; i < begin + count; ++i) find_light(eye_hits_[i], eye_rays_[i]);
  }
  eye_hits_.clear();
  eye_rays_.clear();
}

/// Light of a place that an eye ray found, by the share that the balance heuristic gives to it.
float Estimator::eye_share(const EyeRay& eye, const SurfaceInteraction& y, const RayHit& ray,
                           const LocalLight::Place& place) const {
  if (eye.density == 0) return 1;  // of a delta lobe: nothing else finds it
  const float geometry = std::abs(glm::dot(y.n, ray.ray.d)) / sqr(ray.ray.tmax);
  const float by_eye =
      eye.density * geometry * place.eye_ratio / eye_rates_[eye.rates + place.cell];
  return std::isfinite(by_eye) ? by_eye / (1 + by_eye) : 1;
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
      *eye.sum += eye.weight * radiance * eye_share(eye, y, ray, local.surface_place(y));
    }
  }
  if (local.max_depth() < LocalLight::kBounceDepth) return;
  const Bsdf& bsdf = y.shape->bsdf();
  if (any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
    const auto arrival = local.sample_arrival(
        y, random_float(eye.seed, 0), {random_float(eye.seed, 1), random_float(eye.seed, 2)});
    if (arrival) {
      const Rgb f =
          bsdf.eval_pdf(y, Lobe::kDiffuse | Lobe::kGlossy, y.frame.to_local(arrival->d)).f;
      push_shadow_ray(y.shadow_ray(arrival->d, arrival->distance),
                      eye.weight * f * arrival->radiance * eye_share(eye, y, ray, arrival->place),
                      0, -1, eye.sum);
    }
  }
  if (any(bsdf.lobes() & Lobe::kDelta)) look_behind(y, eye);
}

/// Light that a mirror shows to where an eye ray comes from: no light point is on a mirror.
void Estimator::look_behind(const SurfaceInteraction& y, const EyeRay& eye) {
  const Vec2 u(random_float(eye.seed, 3), random_float(eye.seed, 4));
  const auto sample = y.shape->bsdf().sample(y, Lobe::kDelta, 0.5f, u);
  if (!sample || is_black(sample->weight)) return;
  RayHit next;
  next.ray.d = y.frame.to_world(sample->wo);
  next.ray.o = y.ray_origin(next.ray.d);
  scene_->intersect({&next, 1}, Coherence::kIncoherent, *counters_);
  ++(*counters_)[RayKind::kBsdf];
  Rgb radiance(0.f);
  if (!next.hit.valid()) {
    if (light_.environment) radiance = light_.environment->eval_environment(next.ray.d);
  } else {
    const SurfaceInteraction x = scene_->interaction(next);
    if (const Emitter* const emitter = x.shape->emitter()) radiance = emitter->eval_surface(x);
  }
  *eye.sum += eye.weight * sample->weight * radiance;
}

}  // namespace kinome

#include "direct_light.h"

namespace kinome {
namespace {

/// Of so few emitters one number picks one and then, stretched, a place on it: the places on each
/// are spread as evenly as all of them. Of more, too few of its digits would be left.
constexpr uint32_t kMostStretched = 64;

/// Weight of a sample from a technique of density a, where another has density b. As a ratio it
/// neither overflows nor divides zero by zero (a is positive).
float power_heuristic(float a, float b) {
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

}  // namespace

void collect_shading_points(const PrimaryBatch& primary, std::vector<ShadingPoint>& points) {
  points.clear();
  for (uint32_t i = 0; i < primary.size(); ++i) {
    if (primary.hit(i) && primary.interaction(i).shape->bsdf().lobes() != Lobe::kNone) {
      points.push_back({&primary.interaction(i), &primary.key(i), Rgb(1.f), i});
    }
  }
}

void DirectLight::begin(std::span<const ShadingPoint> points) {
  points_ = points;
  // Rays are left over only where an earlier render on this thread threw.
  shadow_rays_.clear(), shadow_pending_.clear();
  directions_.clear(), bsdf_rays_.clear();
}

void DirectLight::add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                                 uint32_t owner, RayKind kind) {
  ++context.counters[kind];
  shadow_rays_.push_back(ray);
  shadow_pending_.push_back({contribution, owner});
}

void DirectLight::sample_emitters(const Context& context, uint32_t dimension) {
  const auto& emitters = context.scene.emitters();
  const auto per_point = static_cast<uint32_t>(context.emitter_samples);
  const auto count = static_cast<uint32_t>(emitters.size());
  positions_.clear();
  numbers_.clear();
  picks_.clear();
  for (const ShadingPoint& point : points_) {
    for (uint32_t k = 0; k < per_point; ++k) {
      const uint32_t first = dimension + kLightDimensions * k;
      positions_.push_back(point.si->p);
      numbers_.push_back(context.sampler.value_2d(*point.key, first + 1));
      if (count == 1) continue;
      float& x = numbers_.back().x;
      const float u = (count <= kMostStretched ? x : context.sampler.value_1d(*point.key, first)) *
                      static_cast<float>(count);
      picks_.push_back(std::min(static_cast<uint32_t>(u), count - 1));
      if (count > kMostStretched) continue;
      x = std::min(u - static_cast<float>(picks_.back()), kOneMinusEpsilon);
    }
  }
  lights_.resize(positions_.size());
  if (emitters.size() == 1) {
    emitters[0]->sample_direct_batch(positions_, numbers_, lights_);
  } else {
    for (size_t i = 0; i < lights_.size(); ++i) {
      const auto light = emitters[picks_[i]]->sample_direct(positions_[i], numbers_[i]);
      lights_[i] = light ? *light : DirectSample{};
    }
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    evaluate_emitter_samples(context, points_[i], i * per_point);
  }
}

void DirectLight::evaluate_emitter_samples(const Context& context, const ShadingPoint& point,
                                           size_t first) {
  const SurfaceInteraction& si = *point.si;
  const Bsdf& bsdf = si.shape->bsdf();
  const auto n_emitter = static_cast<float>(context.emitter_samples);
  const auto n_bsdf = static_cast<float>(context.bsdf_samples);
  valid_.clear();
  x_.clear(), y_.clear(), z_.clear();
  if (any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
    for (size_t i = first; i < first + static_cast<size_t>(context.emitter_samples); ++i) {
      if (lights_[i].pdf == 0 || is_black(lights_[i].radiance)) continue;
      const auto& emitter = context.scene.emitters()[picks_.empty() ? 0 : picks_[i]];
      const bool is_own = emitter->shape() == si.shape;
      if (is_own && !si.resolves(lights_[i].d, lights_[i].distance)) continue;
      const Vec3 wo = si.frame.to_local(lights_[i].d);
      x_.push_back(wo.x), y_.push_back(wo.y), z_.push_back(wo.z);
      valid_.push_back(static_cast<uint32_t>(i));
    }
  }
  const size_t count = valid_.size();
  uint64_t traced = 0;
  if (count > 0) {
    r_.resize(count), g_.resize(count), b_.resize(count), pdf_.resize(count);
    bsdf.eval_pdf(si, Lobe::kAll, {x_.data(), y_.data(), z_.data(), count},
                  {r_.data(), g_.data(), b_.data(), n_bsdf > 0 ? pdf_.data() : nullptr});
  }
  for (size_t k = 0; k < count; ++k) {
    const Rgb f(r_[k], g_[k], b_[k]);
    if (is_black(f)) continue;
    const DirectSample& light = lights_[valid_[k]];
    const float pdf = light.pdf * context.pick_pdf();
    const float weight =
        light.is_delta || n_bsdf == 0 ? 1 : power_heuristic(pdf * n_emitter, pdf_[k] * n_bsdf);
    const Rgb contribution = point.throughput * f * light.radiance * (weight / (pdf * n_emitter));
    if (is_black(contribution)) continue;
    ++traced;
    add_shadow_ray(context, si.shadow_ray(light.d, light.distance), contribution, point.owner,
                   RayKind::kShadow);
  }
  context.counters.skipped_shadow_rays += static_cast<uint64_t>(context.emitter_samples) - traced;
}

float DirectLight::bsdf_weight(const Context& context, float bsdf_pdf, float emitter_pdf) const {
  if (bsdf_pdf == 0 || context.emitter_samples == 0) return 1;
  return power_heuristic(
      bsdf_pdf * static_cast<float>(context.bsdf_samples),
      emitter_pdf * context.pick_pdf() * static_cast<float>(context.emitter_samples));
}

void DirectLight::sample_bsdfs(const Context& context, uint32_t dimension) {
  const float share = 1 / static_cast<float>(context.bsdf_samples);
  for (uint32_t i = 0; i < points_.size(); ++i) {
    const ShadingPoint& point = points_[i];
    const SurfaceInteraction& si = *point.si;
    for (int k = 0; k < context.bsdf_samples; ++k) {
      const uint32_t first = dimension + kLightDimensions * static_cast<uint32_t>(k);
      const auto sample =
          si.shape->bsdf().sample(si, Lobe::kAll, context.sampler.value_1d(*point.key, first),
                                  context.sampler.value_2d(*point.key, first + 1));
      if (!sample || is_black(sample->weight)) {
        ++context.counters.skipped_shadow_rays;
        continue;
      }
      const bool is_delta = any(sample->lobe & Lobe::kDelta);
      directions_.push_back({si.frame.to_world(sample->wo),
                             point.throughput * sample->weight * share, is_delta ? 0 : sample->pdf,
                             i});
    }
  }
}

void DirectLight::make_bsdf_rays(const Context& context) {
  context.counters[RayKind::kBsdf] += directions_.size();
  for (const BsdfDirection& direction : directions_) {
    const SurfaceInteraction& si = *points_[direction.point].si;
    bsdf_rays_.push_back({si.shadow_ray(direction.d, kInfinity), Hit{}});
  }
}

/// Of the directions in `toward_`.
void DirectLight::evaluate_environment(const Context& context) {
  environment_.resize(toward_.size());
  environment_pdf_.resize(toward_.size());
  const bool weighted = context.emitter_samples > 0;
  context.scene.environment()->eval_environment_batch(
      toward_, environment_, weighted ? std::span(environment_pdf_) : std::span<float>());
}

void DirectLight::find_environment(const Context& context) {
  toward_.clear();
  for (const BsdfDirection& direction : directions_) toward_.push_back(direction.d);
  evaluate_environment(context);
  for (size_t k = 0; k < directions_.size(); ++k) {
    const BsdfDirection& direction = directions_[k];
    const Rgb contribution = direction.weight * environment_[k] *
                             bsdf_weight(context, direction.pdf, environment_pdf_[k]);
    if (is_black(contribution)) {
      ++context.counters.skipped_shadow_rays;
      continue;
    }
    const ShadingPoint& point = points_[direction.point];
    add_shadow_ray(context, point.si->shadow_ray(direction.d, kInfinity), contribution, point.owner,
                   RayKind::kBsdf);
  }
  directions_.clear();
}

void DirectLight::trace_shadow_rays(const Context& context, std::span<Rgb> radiance) {
  context.scene.occluded(shadow_rays_, Coherence::kIncoherent, context.counters);
  for (size_t k = 0; k < shadow_rays_.size(); ++k) {
    const Pending& pending = shadow_pending_[k];
    if (!shadow_rays_[k].is_occluded()) radiance[pending.owner] += pending.contribution;
  }
  shadow_rays_.clear();
  shadow_pending_.clear();
}

void DirectLight::add_surface_light(const Context& context, std::span<Rgb> radiance,
                                    const BsdfDirection& direction, const SurfaceInteraction& si) {
  const Emitter& emitter = *si.shape->emitter();
  const Rgb light = emitter.eval_surface(si);
  if (is_black(light)) return;
  const ShadingPoint& point = points_[direction.point];
  const float emitter_pdf = emitter.pdf_surface(point.si->p, si);
  radiance[point.owner] +=
      direction.weight * light * bsdf_weight(context, direction.pdf, emitter_pdf);
}

void DirectLight::trace_nearest(const Context& context) {
  context.scene.intersect(bsdf_rays_, Coherence::kIncoherent, context.counters);
}

void DirectLight::trace_bsdf_rays(const Context& context, std::span<Rgb> radiance) {
  trace_nearest(context);
  for (size_t k = 0; k < bsdf_rays_.size(); ++k) {
    const RayHit& ray = bsdf_rays_[k];
    if (!ray.hit.valid() || !context.scene.shapes()[ray.hit.shape]->emitter()) continue;
    add_surface_light(context, radiance, directions_[k], context.scene.interaction(ray));
  }
  add_environment(context, radiance);
}

/// What BSDF rays that leave the scene meet.
void DirectLight::add_environment(const Context& context, std::span<Rgb> radiance) {
  if (!context.scene.environment()) return;
  missed_.clear();
  toward_.clear();
  for (uint32_t k = 0; k < bsdf_rays_.size(); ++k) {
    if (bsdf_rays_[k].hit.valid()) continue;
    missed_.push_back(k);
    toward_.push_back(directions_[k].d);
  }
  if (missed_.empty()) return;
  evaluate_environment(context);
  for (size_t i = 0; i < missed_.size(); ++i) {
    const BsdfDirection& direction = directions_[missed_[i]];
    radiance[points_[direction.point].owner] +=
        direction.weight * environment_[i] *
        bsdf_weight(context, direction.pdf, environment_pdf_[i]);
  }
}

}  // namespace kinome

#include "transport/camera/guides.h"

#include <algorithm>

#include "kinome/block_points.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {
namespace {

/// Maximum number of mirrors and surfaces of glass that a ray passes.
constexpr uint32_t kMaxSmoothSurfaces = 12;

/// True if the BSDF has perfect mirror reflection or smooth refraction, and no other lobes.
bool is_smooth(const Bsdf& bsdf) {
  return any(bsdf.lobes() & Lobe::kDelta) && !any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
}

kinome::Vec3 normal_of(const Bsdf& bsdf, const SurfaceInteraction& si) {
  const kinome::Vec3 n = bsdf.reflection_frame(si).n;
  return glm::dot(n, si.frame.to_world(si.wi)) < 0 ? -n : n;
}

}  // namespace

Guides::Guides(const SceneTable& scene, const Sensor& sensor, size_t rays)
    : scene_(scene),
      sampler_(sensor.sampler()),
      arena_(rays + kBlockLanes),
      albedo_(arena_.three()),
      normal_(arena_.three()),
      weight_(arena_.three()),
      u_(arena_.floats()),
      rays_{arena_.ray_hits(), arena_.ray_hits()},
      sample_of_{arena_.indices(), arena_.indices()},
      surfaces_(scene, rays) {}

void Guides::record(uint32_t sample, const kinome::Rgb& color) {
  const kinome::Rgb albedo = glm::clamp(weight_.at(sample) * color, 0.f, 1.f);
  albedo_.set(sample, is_finite(albedo) ? albedo : kinome::Rgb(0.f));
}

void Guides::record_sky(const RayHit16* rays, const uint32_t* sample_of) {
  const Emitter* const environment = scene_.scene().environment();
  for (const uint32_t k : surfaces_.missed()) {
    const kinome::Vec3 d = ray_of(&rays[k / kBlockLanes].ray, k % kBlockLanes).d;
    record(sample_of[k], environment ? environment->eval_environment(d) : kinome::Rgb(0.f));
  }
}

bool Guides::follow(const SurfaceInteraction& si, uint32_t sample, bool may_continue, Ray& next) {
  const Bsdf& bsdf = si.shape->bsdf();
  const float u = may_continue ? u_[sample] : 1.f;
  const kinome::Rgb weight = weight_.at(sample);
  if (bsdf.has_null_lobe() && !is_smooth(bsdf)) {
    const NullTransmission through = bsdf.null_transmission(si);
    if (u < through.probability) {
      weight_.set(sample, weight * through.transmittance / through.probability);
      next = si.spawn_ray(-si.frame.to_world(si.wi));
      return true;
    }
  }
  normal_.set(sample, normal_of(bsdf, si));
  if (const Emitter* const emitter = si.shape->emitter()) {
    record(sample, emitter->eval_surface(si));
    return false;
  }
  if (!is_smooth(bsdf)) {
    const LobeReflectance reflectance = bsdf.reflectance(si);
    record(sample, reflectance.diffuse + reflectance.glossy);
    return false;
  }
  if (may_continue) {
    if (const auto bounce = bsdf.sample(si, Lobe::kDelta, u, kinome::Vec2(0.5f))) {
      weight_.set(sample, weight * bounce->weight);
      next = si.spawn_ray(si.frame.to_world(bounce->wo));
      return true;
    }
  }
  record(sample, kinome::Rgb(0.f));
  return false;
}

void Guides::find(const Camera& camera, const PixelSamples& samples, RenderCounters& counters) {
  const size_t count = samples.count();
  for (size_t i = 0; i < count; ++i) {
    albedo_.set(i, kinome::Vec3(0.f));
    normal_.set(i, kinome::Vec3(0.f));
    weight_.set(i, kinome::Vec3(1.f));
    sample_of_[0][i] = static_cast<uint32_t>(i);
  }
  const RayHit16* rays = camera.rays();
  size_t live = count;
  for (uint32_t depth = 0; live > 0; ++depth) {
    const uint32_t* const sample_of = sample_of_[depth % 2];
    RayHit16* const next_rays = rays_[depth % 2];
    uint32_t* const next_sample_of = sample_of_[1 - depth % 2];
    surfaces_.find(rays, live, Surfaces::Which::kAll);
    record_sky(rays, sample_of);
    const bool may_continue = depth < kMaxSmoothSurfaces;
    if (may_continue) sampler_.fill_1d_block(samples, kCameraDimensions + depth, u_);
    live = 0;
    for (const Surfaces::Range& range : surfaces_.ranges()) {
      for (size_t i = range.first; i < range.first + range.count; ++i) {
        const uint32_t sample = sample_of[surfaces_.points().ray[i]];
        Ray next;
        if (!follow(interaction_of(surfaces_.points(), i), sample, may_continue, next)) continue;
        set_ray(next_rays[live / kBlockLanes].ray, live % kBlockLanes, next);
        next_sample_of[live++] = sample;
      }
    }
    if (live == 0) break;
    disable_padding(next_rays, live);
    clear_hits(next_rays, live);
    scene_.scene().intersect(next_rays, padded(live) / kBlockLanes, Coherence::kIncoherent,
                             counters);
    counters[RayKind::kCamera] += live;
    rays = next_rays;
  }
}

}  // namespace kinome::transport

#include "kinome/point_lights.h"

#include <array>

#include "kinome/primary_rays.h"

namespace kinome {
namespace {

constexpr uint32_t kMirrorDimension = kPrimaryDimensions;       // 3 numbers
constexpr uint32_t kEmitterDimension = kChooseDimensions + 16;  // 2 an emitter without points
/// Shadow rays to one call of Embree.
constexpr size_t kShadowBatch = 4096;
/// Directions to one call of a BSDF.
constexpr size_t kEvaluateBatch = 256;

struct Stages {
  double &primary, &evaluate, &shadow, &film;
  explicit Stages(RenderCounters& counters)
      : primary(counters.stage_seconds["primary"]),
        evaluate(counters.stage_seconds["evaluate"]),
        shadow(counters.stage_seconds["shadow"]),
        film(counters.stage_seconds["film"]) {}
};

/// Memory that a thread keeps from tile to tile.
struct Scratch {
  PrimaryBatch primary;
  PointSelection selection;
  std::vector<Rgb> radiance;  ///< of each primary sample
  std::vector<Ray> rays;      ///< waiting shadow rays, and whom they are for
  std::vector<uint32_t> owner;
  std::vector<Rgb> contribution;
  std::vector<RayHit> mirror_rays;
  std::vector<uint32_t> mirror_owner;
  std::vector<Rgb> mirror_weight;
};

/// Shades the samples of one part of a tile.
class Shader {
 public:
  Shader(const Scene& scene, const ScenePointLights& lights, const ChoosePoints& choose,
         const Sampler& sampler, RenderCounters& counters, Scratch& scratch)
      : scene_(scene),
        lights_(lights),
        choose_(choose),
        sampler_(sampler),
        counters_(counters),
        s_(scratch),
        stages_(counters) {}

  void shade_all(bool hide_emitters) {
    clear_rays();  // some are left only where an earlier render on this thread threw
    s_.radiance.assign(s_.primary.size(), Rgb(0.f));
    for (uint32_t i = 0; i < s_.primary.size(); ++i) {
      if (!hide_emitters) {
        s_.radiance[i] =
            s_.primary.hit(i) ? s_.primary.emission(i) : s_.primary.environment(scene_, i);
      }
      if (s_.primary.hit(i)) shade(i);
    }
    trace_shadow_rays();
    trace_mirror_rays();
  }

 private:
  void shade(uint32_t i) {
    const SurfaceInteraction& si = s_.primary.interaction(i);
    const Bsdf& bsdf = si.shape->bsdf();
    if (any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
      if (lights_.points.size() > 0) {
        s_.selection.clear();
        choose_(si, s_.primary.key(i), counters_, s_.selection);
        const size_t chosen = s_.selection.points.size();
        for (size_t first = 0; first < chosen; first += kEvaluateBatch) {
          evaluate(i, si, first, std::min(kEvaluateBatch, chosen - first));
          if (s_.rays.size() >= kShadowBatch) trace_shadow_rays();
        }
      }
      sample_others(i, si);
    }
    if (any(bsdf.lobes() & Lobe::kDelta)) reflect(i, si);
  }

  /// Selected points [first, first + count): their reflected radiance, and a shadow ray for each
  /// that has any.
  void evaluate(uint32_t i, const SurfaceInteraction& si, size_t first, size_t count) {
    const StageTimer timer(stages_.evaluate);
    std::array<float, kEvaluateBatch> x, y, z, r, g, b;
    const uint32_t* const points = s_.selection.points.data() + first;
    for (size_t k = 0; k < count; ++k) {
      const Vec3 d = si.frame.to_local(lights_.points.position[points[k]]);
      x[k] = d.x;
      y[k] = d.y;
      z[k] = d.z;
    }
    si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy,
                              {x.data(), y.data(), z.data(), count},
                              {r.data(), g.data(), b.data(), nullptr});
    for (size_t k = 0; k < count; ++k) {
      const Rgb reflected = Rgb(r[k], g[k], b[k]) * lights_.points.power[points[k]];
      add_shadow_ray(i, si, lights_.points.position[points[k]], kInfinity,
                     reflected * s_.selection.weights[first + k]);
    }
  }

  void sample_others(uint32_t i, const SurfaceInteraction& si) {
    SampleStream numbers = stream(i, kEmitterDimension);
    for (const Emitter* emitter : lights_.others) {
      const auto light = emitter->sample_direct(si.p, numbers.next_2d());
      if (!light) continue;
      const BsdfValue value = si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy,
                                                        si.frame.to_local(light->d));
      add_shadow_ray(i, si, light->d, light->distance, value.f * light->radiance / light->pdf);
    }
  }

  void reflect(uint32_t i, const SurfaceInteraction& si) {
    SampleStream numbers = stream(i, kMirrorDimension);
    const float u1 = numbers.next_1d();
    const auto sample = si.shape->bsdf().sample(si, Lobe::kDelta, u1, numbers.next_2d());
    if (!sample || is_black(sample->weight)) return;
    RayHit ray;
    const Vec3 d = si.frame.to_world(sample->wo);
    ray.ray.o = si.ray_origin(d);
    ray.ray.d = d;
    s_.mirror_rays.push_back(ray);
    s_.mirror_owner.push_back(i);
    s_.mirror_weight.push_back(sample->weight);
  }

  SampleStream stream(uint32_t i, uint32_t dimension) const {
    return {sampler_, s_.primary.key(i), dimension};
  }

  void add_shadow_ray(uint32_t i, const SurfaceInteraction& si, const Vec3& d, float distance,
                      const Rgb& contribution) {
    if (is_black(contribution)) {
      ++counters_.skipped_shadow_rays;
      return;
    }
    s_.rays.push_back(si.shadow_ray(d, distance));
    s_.owner.push_back(i);
    s_.contribution.push_back(contribution);
  }

  void trace_shadow_rays() {
    const StageTimer timer(stages_.shadow);
    scene_.occluded(s_.rays, Coherence::kIncoherent, counters_);
    counters_[RayKind::kShadow] += s_.rays.size();
    for (size_t k = 0; k < s_.rays.size(); ++k) {
      if (!s_.rays[k].is_occluded()) s_.radiance[s_.owner[k]] += s_.contribution[k];
    }
    clear_shadow_rays();
  }

  void trace_mirror_rays() {
    scene_.intersect(s_.mirror_rays, Coherence::kIncoherent, counters_);
    counters_[RayKind::kBsdf] += s_.mirror_rays.size();
    for (size_t k = 0; k < s_.mirror_rays.size(); ++k) {
      const RayHit& ray = s_.mirror_rays[k];
      Rgb light(0.f);
      if (!ray.hit.valid()) {
        if (const Emitter* e = scene_.environment()) light = e->eval_environment(ray.ray.d);
      } else if (const Emitter* e = scene_.shapes()[ray.hit.shape]->emitter()) {
        light = e->eval_surface(scene_.interaction(ray));
      }
      s_.radiance[s_.mirror_owner[k]] += s_.mirror_weight[k] * light;
    }
    clear_rays();
  }

  void clear_shadow_rays() {
    s_.rays.clear();
    s_.owner.clear();
    s_.contribution.clear();
  }
  void clear_rays() {
    clear_shadow_rays();
    s_.mirror_rays.clear();
    s_.mirror_owner.clear();
    s_.mirror_weight.clear();
  }

  const Scene& scene_;
  const ScenePointLights& lights_;
  const ChoosePoints& choose_;
  const Sampler& sampler_;
  RenderCounters& counters_;
  Scratch& s_;
  Stages stages_;
};

void append(LightPoints& to, const LightPoints& from) {
  to.position.insert(to.position.end(), from.position.begin(), from.position.end());
  to.power.insert(to.power.end(), from.power.begin(), from.power.end());
  to.extent.insert(to.extent.end(), from.extent.begin(), from.extent.end());
}

}  // namespace

ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context,
                                     uint32_t count) {
  ScenePointLights lights;
  for (const Emitter* emitter : scene.emitters()) {
    const auto points = emitter->light_points(scene, context, count);
    if (points && points->kind == LightPoints::Kind::kDistant && points->size() > 0) {
      append(lights.points, *points);
    } else {
      lights.others.push_back(emitter);
    }
  }
  return lights;
}

void render_point_lights(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         const ScenePointLights& lights, bool hide_emitters,
                         const ChoosePoints& choose) {
  Film& film = sensor.film();
  const Sampler& sampler = sensor.sampler();
  const uint64_t seed = key_seed(context, sampler);
  context.for_each_tile(film, [&](Tile& tile) {
    thread_local Scratch scratch;
    Stages stages(tile.counters);
    for_each_part(tile.pixels, sampler.sample_count(), 2048, [&](uint32_t first, uint32_t count) {
      {
        const StageTimer timer(stages.primary);
        scratch.primary.trace(scene, sensor, tile.pixels, first, count, seed, tile.counters);
      }
      Shader(scene, lights, choose, sampler, tile.counters, scratch).shade_all(hide_emitters);
      const StageTimer timer(stages.film);
      for (size_t i = 0; i < scratch.primary.size(); ++i) {
        const Rgb& L = scratch.radiance[i];
        const float values[4] = {L.x, L.y, L.z, scratch.primary.hit(i) ? 1.f : 0.f};
        tile.film.add(scratch.primary.film_position(i), {values, film.has_alpha() ? 4u : 3u});
      }
    });
  });
}

}  // namespace kinome

/// Direct illumination, as Mitsuba's `direct`: at each first hit, directions from the emitters and
/// from the BSDF, combined by the power heuristic (Veach 1997, 9.2.4). Emitters are picked
/// uniformly. Shadow rays of many points are traced as one batch; none is traced for a
/// contribution of zero.
///
///     <integrator type="direct"><integer name="shading_samples" value="4"/></integrator>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"shading_samples", ParameterType::kInteger, "1",
     "Emitter samples and BSDF samples for each primary ray: this many of both."},
    {"emitter_samples", ParameterType::kInteger, nullptr,
     "Emitter samples alone (default: shading_samples). Not together with shading_samples."},
    {"bsdf_samples", ParameterType::kInteger, nullptr,
     "BSDF samples alone (default: shading_samples). Not together with shading_samples."},
    {"hide_emitters", ParameterType::kBoolean, "false", "Light itself is black to the camera."},
};

/// Primary rays traced together, and shadow rays at which a batch is full: what fits the caches.
constexpr uint32_t kPrimaryRays = 2048;
constexpr size_t kShadowRays = 2048;

/// Dimensions of the sampler for one emitter sample (which, where) or BSDF sample (lobe, where).
constexpr uint32_t kDimensions = 3;

int read_count(const Properties& props, const std::string& name) {
  const int64_t count = props.integer(name);
  if (count < 0 || count > 65536) {
    throw props.error(name, "must be 0 to 65536, got " + std::to_string(count));
  }
  return static_cast<int>(count);
}

/// Weight of a sample from a technique of density a, where another has density b. As a ratio it
/// neither overflows nor divides zero by zero (a is positive).
float power_heuristic(float a, float b) {
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

struct Settings {
  int emitter_samples;
  int bsdf_samples;
  bool hide_emitters;
};

/// What one thread works with; kept from tile to tile.
class DirectShader {
 public:
  void shade(const Settings& settings, const Scene& scene, const Sensor& sensor, uint64_t seed,
             uint32_t first_sample, uint32_t samples, Tile& tile);

 private:
  /// Light that reaches the camera if nothing is in its ray's way.
  struct Pending {
    Rgb contribution;
    uint32_t owner;
  };
  struct Context {
    const Settings& settings;
    const Scene& scene;
    const Sampler& sampler;
    RenderCounters& counters;
    double& shadow_seconds;
    float pick_pdf;  ///< of each emitter
  };

  void sample_emitters(const Context& context, uint32_t i);
  void sample_bsdf(const Context& context, uint32_t i);
  void add_emitter_ray(const Context& context, uint32_t i, const DirectSample& light,
                       const BsdfValue& bsdf);
  void add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                      uint32_t owner, RayKind kind);
  void trace_shadow_rays(const Context& context);
  void trace_bsdf_rays(const Context& context);
  void add_to_film(const Settings& settings, const Scene& scene, size_t value_count,
                   FilmTile& film) const;

  PrimaryBatch primary_;
  std::vector<Rgb> radiance_;
  std::vector<Ray> shadow_rays_;
  std::vector<Pending> shadow_pending_;

  /// BSDF rays that look for the nearest surface, where surfaces emit. Contribution: the weight of
  /// the BSDF sample; the density tells how to weigh what the ray meets (0: a delta lobe).
  struct BsdfPending {
    Rgb weight;
    float pdf;
    uint32_t owner;
  };
  std::vector<RayHit> bsdf_rays_;
  std::vector<BsdfPending> bsdf_pending_;

  /// Emitter samples of one point, evaluated by its BSDF as a batch.
  std::vector<DirectSample> lights_;
  std::vector<float> x_, y_, z_, r_, g_, b_, pdf_;
};

void DirectShader::add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                                  uint32_t owner, RayKind kind) {
  if (is_black(contribution)) {
    ++context.counters.skipped_shadow_rays;
    return;
  }
  ++context.counters[kind];
  shadow_rays_.push_back(ray);
  shadow_pending_.push_back({contribution, owner});
}

void DirectShader::add_emitter_ray(const Context& context, uint32_t i, const DirectSample& light,
                                   const BsdfValue& bsdf) {
  const Settings& settings = context.settings;
  const float pdf = light.pdf * context.pick_pdf;
  const auto n_emitter = static_cast<float>(settings.emitter_samples);
  const auto n_bsdf = static_cast<float>(settings.bsdf_samples);
  const float weight =
      light.is_delta || n_bsdf == 0 ? 1 : power_heuristic(pdf * n_emitter, bsdf.pdf * n_bsdf);
  const Rgb contribution = bsdf.f * light.radiance * (weight / (pdf * n_emitter));
  add_shadow_ray(context, primary_.interaction(i).shadow_ray(light.d, light.distance), contribution,
                 i, RayKind::kShadow);
}

void DirectShader::sample_emitters(const Context& context, uint32_t i) {
  const auto& emitters = context.scene.emitters();
  const SurfaceInteraction& si = primary_.interaction(i);
  const SampleKey& key = primary_.key(i);
  lights_.clear();
  x_.clear(), y_.clear(), z_.clear();
  for (int k = 0; k < context.settings.emitter_samples; ++k) {
    const uint32_t dimension = kPrimaryDimensions + kDimensions * static_cast<uint32_t>(k);
    size_t pick = 0;
    if (emitters.size() > 1) {
      const float u = context.sampler.value_1d(key, dimension);
      pick = std::min(static_cast<size_t>(u * static_cast<float>(emitters.size())),
                      emitters.size() - 1);
    }
    const auto light =
        emitters[pick]->sample_direct(si.p, context.sampler.value_2d(key, dimension + 1));
    if (!light || is_black(light->radiance)) {
      ++context.counters.skipped_shadow_rays;
      continue;
    }
    lights_.push_back(*light);
    const Vec3 wo = si.frame.to_local(light->d);
    x_.push_back(wo.x), y_.push_back(wo.y), z_.push_back(wo.z);
  }
  const size_t count = lights_.size();
  if (count == 0) return;
  r_.resize(count), g_.resize(count), b_.resize(count), pdf_.resize(count);
  si.shape->bsdf().eval_pdf(
      si, Lobe::kAll, {x_.data(), y_.data(), z_.data(), count},
      {r_.data(), g_.data(), b_.data(), context.settings.bsdf_samples > 0 ? pdf_.data() : nullptr});
  for (size_t k = 0; k < count; ++k) {
    add_emitter_ray(context, i, lights_[k], {Rgb(r_[k], g_[k], b_[k]), pdf_[k]});
  }
}

void DirectShader::sample_bsdf(const Context& context, uint32_t i) {
  const Settings& settings = context.settings;
  const SurfaceInteraction& si = primary_.interaction(i);
  const SampleKey& key = primary_.key(i);
  const Emitter* const environment = context.scene.environment();
  const auto n_bsdf = static_cast<float>(settings.bsdf_samples);
  const auto n_emitter = static_cast<float>(settings.emitter_samples);
  for (int k = 0; k < settings.bsdf_samples; ++k) {
    const uint32_t dimension =
        kPrimaryDimensions + kDimensions * static_cast<uint32_t>(settings.emitter_samples + k);
    const auto sample =
        si.shape->bsdf().sample(si, Lobe::kAll, context.sampler.value_1d(key, dimension),
                                context.sampler.value_2d(key, dimension + 1));
    if (!sample || is_black(sample->weight)) {
      ++context.counters.skipped_shadow_rays;
      continue;
    }
    const Vec3 d = si.frame.to_world(sample->wo);
    const bool is_delta = any(sample->lobe & Lobe::kDelta);
    const Rgb share = sample->weight / n_bsdf;
    if (context.scene.has_surface_emitters()) {
      ++context.counters[RayKind::kBsdf];
      bsdf_rays_.push_back({si.shadow_ray(d, kInfinity), Hit{}});
      bsdf_pending_.push_back({share, is_delta ? 0 : sample->pdf, i});
      continue;
    }
    // Only the environment can be met: the ray need but know whether it leaves the scene.
    const Rgb light = environment->eval_environment(d);
    float weight = 1;
    if (!is_delta && n_emitter > 0 && !is_black(light)) {
      weight = power_heuristic(sample->pdf * n_bsdf,
                               environment->pdf_environment(d) * context.pick_pdf * n_emitter);
    }
    add_shadow_ray(context, si.shadow_ray(d, kInfinity), share * light * weight, i, RayKind::kBsdf);
  }
}

void DirectShader::trace_shadow_rays(const Context& context) {
  if (shadow_rays_.empty()) return;
  const StageTimer timer(context.shadow_seconds);
  context.scene.occluded(shadow_rays_, Coherence::kIncoherent, context.counters);
  for (size_t k = 0; k < shadow_rays_.size(); ++k) {
    const Pending& pending = shadow_pending_[k];
    if (!shadow_rays_[k].is_occluded()) radiance_[pending.owner] += pending.contribution;
  }
  shadow_rays_.clear();
  shadow_pending_.clear();
}

void DirectShader::trace_bsdf_rays(const Context& context) {
  if (bsdf_rays_.empty()) return;
  const StageTimer timer(context.shadow_seconds);
  const Settings& settings = context.settings;
  const Emitter* const environment = context.scene.environment();
  context.scene.intersect(bsdf_rays_, Coherence::kIncoherent, context.counters);
  for (size_t k = 0; k < bsdf_rays_.size(); ++k) {
    const RayHit& ray = bsdf_rays_[k];
    const BsdfPending& pending = bsdf_pending_[k];
    Rgb light(0.f);
    float emitter_pdf = 0;
    if (ray.hit.valid()) {
      const SurfaceInteraction si = context.scene.interaction(ray);
      const Emitter* const emitter = si.shape->emitter();
      if (!emitter) continue;
      light = emitter->eval_surface(si);
      emitter_pdf = emitter->pdf_surface(primary_.interaction(pending.owner).p, si);
    } else if (environment) {
      light = environment->eval_environment(ray.ray.d);
      emitter_pdf = environment->pdf_environment(ray.ray.d);
    }
    if (is_black(light)) continue;
    const float weight =
        pending.pdf == 0 || settings.emitter_samples == 0
            ? 1
            : power_heuristic(
                  pending.pdf * static_cast<float>(settings.bsdf_samples),
                  emitter_pdf * context.pick_pdf * static_cast<float>(settings.emitter_samples));
    radiance_[pending.owner] += pending.weight * light * weight;
  }
  bsdf_rays_.clear();
  bsdf_pending_.clear();
}

void DirectShader::add_to_film(const Settings& settings, const Scene& scene, size_t value_count,
                               FilmTile& film) const {
  std::array<float, 4> values;
  const std::span<const float> given(values.data(), value_count);
  for (size_t i = 0; i < primary_.size(); ++i) {
    Rgb radiance = radiance_[i];
    if (!settings.hide_emitters) {
      radiance += primary_.hit(i) ? primary_.emission(i) : primary_.environment(scene, i);
    }
    values = {radiance.x, radiance.y, radiance.z, primary_.hit(i) ? 1.f : 0.f};
    film.add(primary_.film_position(i), given);
  }
}

void DirectShader::shade(const Settings& settings, const Scene& scene, const Sensor& sensor,
                         uint64_t seed, uint32_t first_sample, uint32_t samples, Tile& tile) {
  auto& stages = tile.counters.stage_seconds;
  double& shade_seconds = stages["shade"];
  double& shadow_seconds = stages["shadow"];
  {
    const StageTimer timer(stages["primary"]);
    primary_.trace(scene, sensor, tile.pixels, first_sample, samples, seed, tile.counters);
  }
  radiance_.assign(primary_.size(), Rgb(0.f));
  // Rays are left over only where an earlier render on this thread threw.
  shadow_rays_.clear(), shadow_pending_.clear();
  bsdf_rays_.clear(), bsdf_pending_.clear();
  const auto emitter_count = static_cast<float>(scene.emitters().size());
  const Context context{settings,      scene,          sensor.sampler(),
                        tile.counters, shadow_seconds, 1 / std::max(1.f, emitter_count)};
  const bool has_emitters = !scene.emitters().empty();
  const bool can_meet_light = scene.environment() || scene.has_surface_emitters();
  const double shadow_before = shadow_seconds;
  {
    const StageTimer timer(shade_seconds);
    for (uint32_t i = 0; i < primary_.size(); ++i) {
      if (!primary_.hit(i)) continue;
      const Lobe lobes = primary_.interaction(i).shape->bsdf().lobes();
      if (has_emitters && any(lobes & (Lobe::kDiffuse | Lobe::kGlossy))) {
        sample_emitters(context, i);
      }
      if (can_meet_light && lobes != Lobe::kNone) sample_bsdf(context, i);
      if (shadow_rays_.size() >= kShadowRays) trace_shadow_rays(context);
      if (bsdf_rays_.size() >= kShadowRays) trace_bsdf_rays(context);
    }
    trace_shadow_rays(context);
    trace_bsdf_rays(context);
  }
  shade_seconds -= shadow_seconds - shadow_before;
  const StageTimer timer(stages["film"]);
  add_to_film(settings, scene, static_cast<size_t>(sensor.film().value_count(0)), tile.film);
}

class DirectIntegrator final : public Integrator {
 public:
  explicit DirectIntegrator(const Properties& props) {
    const bool separate = props.has("emitter_samples") || props.has("bsdf_samples");
    if (separate && props.has("shading_samples")) {
      throw props.error("shading_samples",
                        "can't be given together with emitter_samples or bsdf_samples");
    }
    const auto count = [&](const std::string& name) {
      return read_count(props, props.has(name) ? name : "shading_samples");
    };
    settings_ = {count("emitter_samples"), count("bsdf_samples"), props.boolean("hide_emitters")};
    if (settings_.emitter_samples + settings_.bsdf_samples == 0) {
      throw props.error("shading_samples",
                        "there must be at least one emitter sample or BSDF sample");
    }
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) context.skip("shading", "the scene has no emitters");
    if (!scene.has_surface_emitters()) {
      context.skip("nearest hits of BSDF rays", "no surface emits: occlusion is enough");
    }
    const uint32_t count = sensor.sampler().sample_count();
    const uint64_t seed = key_seed(context, sensor.sampler());
    context.for_each_tile(sensor.film(), [&](Tile& tile) {
      thread_local DirectShader shader;
      for_each_part(tile.pixels, count, kPrimaryRays, [&](uint32_t first, uint32_t samples) {
        shader.shade(settings_, scene, sensor, seed, first, samples, tile);
      });
    });
  }

 private:
  Settings settings_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::DirectIntegrator, kinome::Category::kIntegrator, "direct",
              "Direct illumination by emitter and BSDF sampling with multiple importance sampling.",
              kinome::kTable);

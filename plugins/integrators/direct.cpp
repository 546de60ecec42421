/// Direct illumination, as Mitsuba's `direct`: at each first hit, directions from the emitters and
/// from the BSDF, combined by the power heuristic (Veach 1997, 9.2.4). Emitters are picked
/// uniformly. Shadow rays of many points are traced as one batch; none is traced for a
/// contribution of zero.
///
///     <integrator type="direct"><integer name="shading_samples" value="4"/></integrator>

#include <array>
#include <optional>
#include <span>
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
  struct Context {
    const Settings& settings;
    const Scene& scene;
    const Sampler& sampler;
    RenderCounters& counters;
    float pick_pdf;  ///< of each emitter
  };
  /// Light that reaches the camera if nothing is in its ray's way.
  struct Pending {
    Rgb contribution;
    uint32_t owner;
  };
  /// A sampled direction of a BSDF: the sample's weight, and the density that tells how to weigh
  /// what the ray meets (0: a delta lobe, which no emitter sample competes with).
  struct BsdfPending {
    Rgb weight;
    float pdf;
    uint32_t owner;
  };

  void sample_emitters(const Context& context, std::span<const uint32_t> points);
  void evaluate_emitter_samples(const Context& context, uint32_t point, size_t first);
  void sample_bsdfs(const Context& context, std::span<const uint32_t> points);
  void add_environment_rays(const Context& context);
  void add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                      uint32_t owner, RayKind kind);
  float bsdf_sample_weight(const Context& context, float bsdf_pdf, float emitter_pdf) const;
  void trace_shadow_rays(const Context& context);
  void trace_bsdf_rays(const Context& context);
  void add_visible_emitters(const Scene& scene);
  void add_to_film(size_t value_count, FilmTile& film) const;

  PrimaryBatch primary_;
  std::vector<Rgb> radiance_;     ///< of each primary ray
  std::vector<uint32_t> points_;  ///< primary rays that hit something that reflects

  std::vector<Ray> shadow_rays_;
  std::vector<Pending> shadow_pending_;
  std::vector<RayHit> bsdf_rays_;  ///< only where surfaces emit
  std::vector<BsdfPending> bsdf_pending_;

  /// Emitter samples of some points; then, of one point, what its BSDF is asked and says.
  std::vector<Vec3> positions_;
  std::vector<Vec2> numbers_;
  std::vector<uint32_t> picks_;
  std::vector<DirectSample> lights_;
  std::vector<uint32_t> valid_;
  std::vector<float> x_, y_, z_, r_, g_, b_, pdf_;

  /// Directions in which an environment is evaluated.
  std::vector<Vec3> directions_;
  std::vector<Rgb> environment_;
  std::vector<float> environment_pdf_;
};

void DirectShader::add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                                  uint32_t owner, RayKind kind) {
  ++context.counters[kind];
  shadow_rays_.push_back(ray);
  shadow_pending_.push_back({contribution, owner});
}

void DirectShader::sample_emitters(const Context& context, std::span<const uint32_t> points) {
  const auto& emitters = context.scene.emitters();
  const auto per_point = static_cast<uint32_t>(context.settings.emitter_samples);
  positions_.clear();
  numbers_.clear();
  picks_.clear();
  for (const uint32_t point : points) {
    const SampleKey& key = primary_.key(point);
    for (uint32_t k = 0; k < per_point; ++k) {
      const uint32_t dimension = kPrimaryDimensions + kDimensions * k;
      positions_.push_back(primary_.interaction(point).p);
      numbers_.push_back(context.sampler.value_2d(key, dimension + 1));
      if (emitters.size() == 1) continue;
      const float u =
          context.sampler.value_1d(key, dimension) * static_cast<float>(emitters.size());
      picks_.push_back(
          std::min(static_cast<uint32_t>(u), static_cast<uint32_t>(emitters.size() - 1)));
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
  for (size_t i = 0; i < points.size(); ++i) {
    evaluate_emitter_samples(context, points[i], i * per_point);
  }
}

void DirectShader::evaluate_emitter_samples(const Context& context, uint32_t point, size_t first) {
  const SurfaceInteraction& si = primary_.interaction(point);
  const Bsdf& bsdf = si.shape->bsdf();
  const auto n_emitter = static_cast<float>(context.settings.emitter_samples);
  const auto n_bsdf = static_cast<float>(context.settings.bsdf_samples);
  valid_.clear();
  x_.clear(), y_.clear(), z_.clear();
  if (any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
    for (size_t i = first; i < first + static_cast<size_t>(context.settings.emitter_samples); ++i) {
      if (lights_[i].pdf == 0 || is_black(lights_[i].radiance)) continue;
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
    const float pdf = light.pdf * context.pick_pdf;
    const float weight =
        light.is_delta || n_bsdf == 0 ? 1 : power_heuristic(pdf * n_emitter, pdf_[k] * n_bsdf);
    const Rgb contribution = f * light.radiance * (weight / (pdf * n_emitter));
    if (is_black(contribution)) continue;
    ++traced;
    add_shadow_ray(context, si.shadow_ray(light.d, light.distance), contribution, point,
                   RayKind::kShadow);
  }
  context.counters.skipped_shadow_rays +=
      static_cast<uint64_t>(context.settings.emitter_samples) - traced;
}

float DirectShader::bsdf_sample_weight(const Context& context, float bsdf_pdf,
                                       float emitter_pdf) const {
  if (bsdf_pdf == 0 || context.settings.emitter_samples == 0) return 1;
  return power_heuristic(
      bsdf_pdf * static_cast<float>(context.settings.bsdf_samples),
      emitter_pdf * context.pick_pdf * static_cast<float>(context.settings.emitter_samples));
}

void DirectShader::sample_bsdfs(const Context& context, std::span<const uint32_t> points) {
  const Settings& settings = context.settings;
  const float share = 1 / static_cast<float>(settings.bsdf_samples);
  directions_.clear();
  for (const uint32_t point : points) {
    const SurfaceInteraction& si = primary_.interaction(point);
    const SampleKey& key = primary_.key(point);
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
      directions_.push_back(si.frame.to_world(sample->wo));
      const bool is_delta = any(sample->lobe & Lobe::kDelta);
      bsdf_pending_.push_back({sample->weight * share, is_delta ? 0 : sample->pdf, point});
    }
  }
  if (!context.scene.has_surface_emitters()) {
    add_environment_rays(context);
    return;
  }
  context.counters[RayKind::kBsdf] += directions_.size();
  for (size_t k = 0; k < directions_.size(); ++k) {
    const SurfaceInteraction& si = primary_.interaction(bsdf_pending_[k].owner);
    bsdf_rays_.push_back({si.shadow_ray(directions_[k], kInfinity), Hit{}});
  }
}

/// Only the environment can be met: the rays need but know whether they leave the scene.
void DirectShader::add_environment_rays(const Context& context) {
  const size_t count = directions_.size();
  environment_.resize(count);
  environment_pdf_.resize(context.settings.emitter_samples > 0 ? count : 0);
  context.scene.environment()->eval_environment_batch(directions_, environment_, environment_pdf_);
  for (size_t k = 0; k < count; ++k) {
    const BsdfPending& pending = bsdf_pending_[k];
    const float emitter_pdf = environment_pdf_.empty() ? 0 : environment_pdf_[k];
    const Rgb contribution =
        pending.weight * environment_[k] * bsdf_sample_weight(context, pending.pdf, emitter_pdf);
    if (is_black(contribution)) {
      ++context.counters.skipped_shadow_rays;
      continue;
    }
    const SurfaceInteraction& si = primary_.interaction(pending.owner);
    add_shadow_ray(context, si.shadow_ray(directions_[k], kInfinity), contribution, pending.owner,
                   RayKind::kBsdf);
  }
  bsdf_pending_.clear();
}

void DirectShader::trace_shadow_rays(const Context& context) {
  context.scene.occluded(shadow_rays_, Coherence::kIncoherent, context.counters);
  for (size_t k = 0; k < shadow_rays_.size(); ++k) {
    const Pending& pending = shadow_pending_[k];
    if (!shadow_rays_[k].is_occluded()) radiance_[pending.owner] += pending.contribution;
  }
  shadow_rays_.clear();
  shadow_pending_.clear();
}

void DirectShader::trace_bsdf_rays(const Context& context) {
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
    radiance_[pending.owner] +=
        pending.weight * light * bsdf_sample_weight(context, pending.pdf, emitter_pdf);
  }
  bsdf_rays_.clear();
  bsdf_pending_.clear();
}

void DirectShader::add_visible_emitters(const Scene& scene) {
  directions_.clear();
  points_.clear();
  for (uint32_t i = 0; i < primary_.size(); ++i) {
    if (primary_.hit(i)) {
      if (scene.has_surface_emitters()) radiance_[i] += primary_.emission(i);
    } else if (scene.environment()) {
      directions_.push_back(primary_.ray_hit(i).ray.d);
      points_.push_back(i);
    }
  }
  if (directions_.empty()) return;
  environment_.resize(directions_.size());
  scene.environment()->eval_environment_batch(directions_, environment_, {});
  for (size_t k = 0; k < points_.size(); ++k) radiance_[points_[k]] += environment_[k];
}

void DirectShader::add_to_film(size_t value_count, FilmTile& film) const {
  std::array<float, 4> values;
  const std::span<const float> given(values.data(), value_count);
  for (size_t i = 0; i < primary_.size(); ++i) {
    const Rgb& radiance = radiance_[i];
    values = {radiance.x, radiance.y, radiance.z, primary_.hit(i) ? 1.f : 0.f};
    film.add(primary_.film_position(i), given);
  }
}

void DirectShader::shade(const Settings& settings, const Scene& scene, const Sensor& sensor,
                         uint64_t seed, uint32_t first_sample, uint32_t samples, Tile& tile) {
  auto& stages = tile.counters.stage_seconds;
  {
    const StageTimer timer(stages["primary"]);
    primary_.trace(scene, sensor, tile.pixels, first_sample, samples, seed, tile.counters);
  }
  // Rays are left over only where an earlier render on this thread threw.
  shadow_rays_.clear(), shadow_pending_.clear();
  bsdf_rays_.clear(), bsdf_pending_.clear();
  radiance_.assign(primary_.size(), Rgb(0.f));
  if (!settings.hide_emitters) {
    const StageTimer timer(stages["shade"]);
    add_visible_emitters(scene);
  }
  points_.clear();
  for (uint32_t i = 0; i < primary_.size(); ++i) {
    if (primary_.hit(i) && primary_.interaction(i).shape->bsdf().lobes() != Lobe::kNone) {
      points_.push_back(i);
    }
  }
  const Context context{settings, scene, sensor.sampler(), tile.counters,
                        1 / std::max(1.f, static_cast<float>(scene.emitters().size()))};
  const bool use_emitters = !scene.emitters().empty() && settings.emitter_samples > 0;
  const bool use_bsdfs =
      (scene.environment() || scene.has_surface_emitters()) && settings.bsdf_samples > 0;
  const auto rays_per_point =
      static_cast<size_t>(settings.emitter_samples) + static_cast<size_t>(settings.bsdf_samples);
  const size_t step = std::max<size_t>(1, kShadowRays / rays_per_point);
  for (size_t first = 0; first < points_.size(); first += step) {
    const auto group = std::span(points_).subspan(first, std::min(step, points_.size() - first));
    {
      const StageTimer timer(stages["shade"]);
      if (use_emitters) sample_emitters(context, group);
      if (use_bsdfs) sample_bsdfs(context, group);
    }
    const StageTimer timer(stages["shadow"]);
    trace_shadow_rays(context);
    trace_bsdf_rays(context);
  }
  const StageTimer timer(stages["film"]);
  add_to_film(static_cast<size_t>(sensor.film().value_count(0)), tile.film);
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
                        "must give at least one emitter sample or BSDF sample, got 0 of both");
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

/// Direct illumination, as Mitsuba's `direct`: at each first hit, directions from the emitters and
/// from the BSDF, combined by the power heuristic (Veach 1997, 9.2.4). Emitters are picked
/// uniformly. Shadow rays of many points are traced as one batch; none is traced for a
/// contribution of zero.
///
///     <integrator type="direct"><integer name="shading_samples" value="4"/></integrator>

#include <span>
#include <string>
#include <vector>

#include "direct_light.h"
#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "stages.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"shading_samples", ParameterType::kInteger, "1",
     "Emitter samples and BSDF samples for each primary ray: this many of both."},
    {"emitter_samples", ParameterType::kInteger, nullptr,
     "Emitter samples alone (default: shading_samples). Not together with shading_samples."},
    {"bsdf_samples", ParameterType::kInteger, nullptr,
     "BSDF samples alone (default: shading_samples). Not together with shading_samples."},
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera sees no light itself: it looks through surfaces that emit, at a black sky."},
};

struct Settings {
  int emitter_samples;
  int bsdf_samples;
  bool hide_emitters;
};

/// What one thread works with; kept from batch to batch.
class DirectShader {
 public:
  void shade(const Settings& settings, const Scene& scene, const Sampler& sampler,
             const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters);

 private:
  DirectLight light_;
  std::vector<ShadingPoint> points_;
};

void DirectShader::shade(const Settings& settings, const Scene& scene, const Sampler& sampler,
                         const PrimaryBatch& primary, std::span<Rgb> radiance,
                         RenderCounters& counters) {
  auto& stages = counters.stage_seconds;
  collect_shading_points(primary, points_);
  const DirectLight::Context context{scene, sampler, counters, settings.emitter_samples,
                                     settings.bsdf_samples};
  const bool use_emitters = !scene.emitters().empty() && settings.emitter_samples > 0;
  const bool use_bsdfs =
      (scene.environment() || scene.has_surface_emitters()) && settings.bsdf_samples > 0;
  const auto rays_per_point =
      static_cast<size_t>(settings.emitter_samples) + static_cast<size_t>(settings.bsdf_samples);
  const uint32_t bsdf_dimension =
      kPrimaryDimensions + kLightDimensions * static_cast<uint32_t>(settings.emitter_samples);
  const size_t step = std::max<size_t>(1, kShadowRays / rays_per_point);
  for (size_t first = 0; first < points_.size(); first += step) {
    {
      const StageTimer timer(stages["shade"]);
      light_.begin(std::span(points_).subspan(first, std::min(step, points_.size() - first)));
      if (use_emitters) light_.sample_emitters(context, kPrimaryDimensions);
      if (use_bsdfs) {
        light_.sample_bsdfs(context, bsdf_dimension);
        if (scene.has_surface_emitters()) {
          light_.make_bsdf_rays(context);
        } else {
          light_.find_environment(context);
        }
      }
    }
    const StageTimer timer(stages["shadow"]);
    light_.trace_shadow_rays(context, radiance);
    light_.trace_bsdf_rays(context, radiance);
  }
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
      return static_cast<int>(props.integer(props.has(name) ? name : "shading_samples", 0, 65536));
    };
    settings_ = {count("emitter_samples"), count("bsdf_samples"), props.boolean("hide_emitters")};
    if (settings_.emitter_samples + settings_.bsdf_samples == 0) {
      throw props.error("shading_samples",
                        "must give at least one emitter sample or BSDF sample, got 0 of both");
    }
  }

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kShadeStage, kShadowStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) context.skip("shading", "the scene has no emitters");
    if (!scene.has_surface_emitters()) {
      context.skip("nearest hits of BSDF rays", "no surface emits: occlusion is enough");
    }
    shade_primary_rays(
        scene, sensor, context, settings_.hide_emitters,
        [&](const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters) {
          thread_local DirectShader shader;
          shader.shade(settings_, scene, sensor.sampler(), primary, radiance, counters);
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

/// Direct illumination, as Mitsuba's `direct`: emitter samples and BSDF samples at each first hit,
/// combined by the power heuristic (Veach 1997, 9.2.4). Emitters are chosen uniformly. Points are
/// shaded in blocks; their shadow rays are sorted by direction. No shadow ray is traced for a
/// contribution of zero.
///
///     <integrator type="direct"><integer name="shading_samples" value="4"/></integrator>

#include <algorithm>
#include <optional>
#include <string>

#include "kinome/light_groups.h"
#include "kinome/plugin.h"
#include "transport/direct/direct_light.h"
#include "transport/paths/camera_block.h"
#include "transport/stages.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"shading_samples", ParameterType::kInteger, "1",
     "Number of emitter samples, and of BSDF samples, for each primary ray."},
    {"emitter_samples", ParameterType::kInteger, nullptr,
     "Number of emitter samples (default: shading_samples); excludes shading_samples."},
    {"bsdf_samples", ParameterType::kInteger, nullptr,
     "Number of BSDF samples (default: shading_samples); excludes shading_samples."},
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera doesn't see emitters: it looks through surfaces that emit, and the sky is black, "
     "also behind masks and panes."},
};

/// State of one thread.
struct DirectWorker {
  DirectWorker(const transport::SceneTable& scene, const Sampler& sampler,
               const transport::LightSamples& samples, bool hides_environment)
      : light(scene, sampler, samples, transport::kBlockSamples),
        arena(transport::kBlockSamples),
        straight(hides_environment ? arena.floats() : nullptr) {}
  transport::DirectLight light;
  transport::Arena arena;
  float* straight;  ///< see transport::Vertices
};

void add_light(DirectWorker& worker, const Scene& scene, const transport::LightSamples& counts,
               const transport::CameraBlock& block, const PixelSamples& samples,
               RenderCounters& counters) {
  transport::DirectLight& light = worker.light;
  constexpr auto kDimensions = transport::DirectLight::kDimensions;
  const transport::Surfaces& seen = block.seen();
  if (seen.reflecting() == 0) return;
  const int emitter_samples = scene.emitters().empty() ? 0 : counts.emitter;
  const bool meets_light = scene.environment() || scene.has_surface_emitters();
  const int bsdf_samples = meets_light ? counts.bsdf : 0;
  transport::Vertices vertices{&seen, seen.points().ray, {}};
  vertices.straight = worker.straight;
  for (int k = 0; k < std::max(emitter_samples, bsdf_samples); ++k) {
    const auto dimension = [&](int count, int before) -> std::optional<uint32_t> {
      if (k >= count) return std::nullopt;
      return transport::kCameraDimensions + kDimensions * static_cast<uint32_t>(before + k);
    };
    // Each BSDF sample is a path of its own.
    if (worker.straight) std::fill_n(worker.straight, samples.count(), 1.f);
    {
      const StageTimer timer(counters.stage_seconds["shade"]);
      light.sample(samples, vertices, dimension(emitter_samples, 0),
                   dimension(bsdf_samples, counts.emitter));
    }
    if (k < emitter_samples) light.add_emitter_samples(vertices, block.radiance(), counters);
    if (k >= bsdf_samples) continue;
    if (scene.has_surface_emitters()) {
      light.trace(vertices, transport::Surfaces::Which::kEmitting, block.radiance(), counters);
    } else {
      light.add_environment(vertices, block.radiance(), counters);
    }
  }
}

class DirectIntegrator final : public GroupingIntegrator {
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
    samples_ = {count("emitter_samples"), count("bsdf_samples")};
    hide_emitters_ = props.boolean("hide_emitters");
    if (samples_.emitter + samples_.bsdf == 0) {
      throw props.error("shading_samples",
                        "must give at least one emitter sample or BSDF sample, got 0 of both");
    }
  }

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kShadeStage, kShadowStage, kBounceStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) context.job.skip("shading", "the scene has no emitters");
    if (!scene.has_surface_emitters()) {
      context.job.skip("nearest hits of BSDF rays", "no surface emits: occlusion is enough");
    }
    const transport::SceneTable table(scene, {}, light_groups());
    const PathSettings settings{{2, 5}, hide_emitters_};
    transport::render_blocks<DirectWorker>(
        table, sensor, context, settings,
        [&] {
          return std::make_unique<DirectWorker>(table, sensor.sampler(), samples_,
                                                transport::hides_environment(settings, scene));
        },
        [&](DirectWorker& worker, const transport::CameraBlock& block, const PixelSamples& samples,
            RenderCounters& counters) {
          add_light(worker, scene, samples_, block, samples, counters);
        });
  }

 private:
  transport::LightSamples samples_;
  bool hide_emitters_ = false;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::DirectIntegrator, kinome::Category::kIntegrator, "direct",
              "Direct illumination by emitter and BSDF sampling with multiple importance sampling.",
              kinome::kTable);

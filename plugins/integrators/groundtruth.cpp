// groundtruth: direct light and one bounce from a set of light points, each used exactly once
// (Åkerlund 2008, 5.2).
//
// No light points are chosen: only positions in pixels are sampled. The image is the expectation of
// `clustered` with the same `light_samples`. It takes a shadow ray for each light point above the
// horizon, so use it for small images.
//
//   <integrator type="groundtruth"> <integer name="light_samples" value="32768"/> </integrator>
#include <numeric>

#include "clustered/clustered_stages.h"
#include "clustered/point_light_parameters.h"

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {KINOME_POINT_LIGHT_PARAMETERS};

class GroundTruth final : public Integrator {
 public:
  explicit GroundTruth(const Properties& props) : settings_(read_point_light_parameters(props)) {}

  const char* default_indirect_emitter() const override { return indirect_emitter(settings_); }

  std::vector<Stage> stages() const override {
    return {kLightLeftOutStage, kLightPointsStage, kPrimaryStage, kEvaluateStage,
            kBounceStage,       kShadeStage,       kShadowStage,  kFilmStage};
  }

  void warn_of_ignored_light(const Scene& scene, const Sensor& sensor,
                             RenderContext& context) const override {
    kinome::warn_of_ignored_light(settings_, scene, sensor, context);
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (render_without_surfaces(settings_, scene, sensor, context)) return;
    ScenePointLights lights = gather(settings_, scene, context);
    if (lights.sets.empty()) context.job.skip("light points", "no emitter has any");
    for (PointLightSet& set : lights.sets) {
      PointSelection all;
      all.points.resize(set.points.size());
      std::iota(all.points.begin(), all.points.end(), 0u);
      all.weights.assign(set.points.size(), 1.f);
      set.choose = [all = std::move(all)](const LitPoints& points, RenderCounters&,
                                          const UseChosen& use) {
        points.for_each([&](size_t i, const Bsdf& bsdf) { use(i, bsdf, all); });
      };
    }
    render_point_lights(scene, sensor, context, lights, settings_.options);
  }

 private:
  PointLightSettings settings_;
};

}  // namespace

KINOME_PLUGIN(GroundTruth, Category::kIntegrator, "groundtruth",
              "Direct light from a set of light points, each used exactly once: the expectation of "
              "'clustered' on the same points.",
              kParameters);

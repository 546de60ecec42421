// groundtruth: direct light from a set of points, each used exactly once (Åkerlund 2008, 5.2).
//
// No light is chosen, nothing is estimated but what lies between pixels: the expectation of
// `clustered` with the same `light_samples` is this picture. Costs a shadow ray for each point
// above the horizon, so it is for small pictures.
//
//   <integrator type="groundtruth"> <integer name="light_samples" value="32768"/> </integrator>
#include <numeric>

#include "kinome/plugin.h"
#include "kinome/point_lights.h"

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"light_samples", ParameterType::kInteger, "32768", "Points that each emitter is made of."},
    {"hide_emitters", ParameterType::kBoolean, "false", "Leave lights out of the camera's view."},
};

class GroundTruth final : public Integrator {
 public:
  explicit GroundTruth(const Properties& props) : hide_emitters_(props.boolean("hide_emitters")) {
    const int64_t count = props.integer("light_samples");
    if (count < 1 || count > (1 << 24)) {
      throw props.error("light_samples",
                        "must be between 1 and 16777216, got " + std::to_string(count));
    }
    light_samples_ = static_cast<uint32_t>(count);
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    const ScenePointLights lights = gather_point_lights(scene, context, light_samples_);
    if (lights.points.size() == 0) context.skip("light points", "no emitter offers any");
    std::vector<uint32_t> all(lights.points.size());
    std::iota(all.begin(), all.end(), 0u);
    render_point_lights(scene, sensor, context, lights, hide_emitters_,
                        [&](const SurfaceInteraction&, const SampleKey&, RenderCounters&,
                            PointSelection& selection) {
                          selection.points = all;
                          selection.weights.assign(all.size(), 1.f);
                        });
  }

 private:
  uint32_t light_samples_;
  bool hide_emitters_;
};

}  // namespace

KINOME_PLUGIN(GroundTruth, Category::kIntegrator, "groundtruth",
              "Direct light from a set of light points, each used exactly once: the expectation of "
              "'clustered' on the same points.",
              kParameters);

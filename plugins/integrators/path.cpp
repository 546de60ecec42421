/// Path tracing from the camera, as Mitsuba's `path`; see transport::Paths.
///
///     <integrator type="path"><integer name="max_depth" value="8"/></integrator>

#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "stages.h"
#include "transport/render_paths.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_PATH_PARAMETERS,
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera sees no light itself: it looks through surfaces that emit, at a black sky."},
};

class PathIntegrator final : public Integrator {
 public:
  explicit PathIntegrator(const Properties& props)
      : settings_{PathLength(props), props.boolean("hide_emitters")} {}

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kBounceStage, kShadeStage, kShadowStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    transport::render_paths(settings_, scene, sensor, context);
  }

 private:
  PathSettings settings_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::PathIntegrator, kinome::Category::kIntegrator, "path",
              "Path tracing from the camera with multiple importance sampling: light after any "
              "number of bounces.",
              kinome::kTable);

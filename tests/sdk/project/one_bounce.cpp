// Direct light at the surfaces that the camera sees, by emitter samples and BSDF samples, in blocks
// of samples. Mitsuba's `direct` with default parameters.
//
//     <integrator type="one_bounce"/>

#include <algorithm>
#include <memory>
#include <vector>

#include <kinome/integrator.h>
#include <kinome/plugin.h>
#include <transport/direct/direct_light.h>
#include <transport/paths/camera_block.h>
#include <transport/stages.h>

namespace {

using namespace kinome;

/// State of one thread: buffers for a block of samples.
struct Worker {
  Worker(const transport::SceneTable& scene, const Sampler& sampler)
      : light(scene, sampler, transport::LightSamples{1, 1}, transport::kBlockSamples) {}

  transport::DirectLight light;
};

class OneBounce final : public Integrator {
 public:
  explicit OneBounce(const Properties&) {}

  std::vector<Stage> stages() const override {
    return {kPrimaryStage, kShadeStage, kShadowStage, kBounceStage, kFilmStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    const transport::SceneTable table(scene);
    const PathSettings settings{{2, 5}, false};  // two edges: camera, surface, emitter
    transport::render_blocks<Worker>(
        table, sensor, context, settings,
        [&] { return std::make_unique<Worker>(table, sensor.sampler()); },
        [&](Worker& worker, const transport::CameraBlock& block, const PixelSamples& samples,
            RenderCounters& counters) { shade(worker.light, scene, block, samples, counters); });
  }

 private:
  /// Adds the light that the surfaces of a block reflect to its radiance.
  static void shade(transport::DirectLight& light, const Scene& scene,
                    const transport::CameraBlock& block, const PixelSamples& samples,
                    RenderCounters& counters) {
    constexpr uint32_t kFirst = transport::kCameraDimensions;
    const transport::Surfaces& seen = block.seen();
    if (seen.reflecting() == 0 || scene.emitters().empty()) return;
    const transport::Vertices vertices{&seen, seen.points().ray, {}};
    {
      const StageTimer timer(counters.stage_seconds["shade"]);
      light.sample(samples, vertices, kFirst, kFirst + transport::DirectLight::kDimensions);
    }
    light.add_emitter_samples(vertices, block.radiance(), counters);
    light.trace(vertices, transport::Surfaces::Which::kEmitting, block.radiance(), counters);
  }
};

}  // namespace

KINOME_PLUGIN(OneBounce, Category::kIntegrator, "one_bounce",
              "Direct light, by emitter samples and BSDF samples in blocks.", {});

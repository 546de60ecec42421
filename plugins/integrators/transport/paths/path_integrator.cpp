#include "transport/paths/path_integrator.h"

#include "transport/paths/camera_block.h"
#include "transport/paths/paths.h"

namespace kinome::transport {

void PathIntegrator::render(const Scene& scene, const Sensor& sensor,
                            RenderContext& context) const {
  if (scene.emitters().empty()) context.job.skip("paths", "the scene has no emitters");
  if (settings_.length.max_depth == 0) {
    context.job.skip("paths", "max_depth is 0: the image is black");
    return;
  }
  const SceneTable table(scene, {}, light_groups());
  render_blocks<Paths>(
      table, sensor, context, settings_,
      [&] { return std::make_unique<Paths>(table, sensor.sampler(), settings_, kBlockSamples); },
      [](Paths& paths, const CameraBlock& block, const PixelSamples& samples,
         RenderCounters& counters) {
        paths.add(samples, block.seen(), {block.radiance(), block.radiance()}, counters);
      });
}

}  // namespace kinome::transport

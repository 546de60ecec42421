/// Light tracing, as Mitsuba's `ptracer`: paths begin at emitters, and each of their surface points
/// is connected to the sensor (Veach 1997, 10.1; Dutré and Willems 1994). It finds light that paths
/// from the camera hardly find, such as a spot's light after one bounce.
///
/// Some light is missing. Reflections in mirrors are black. An environment lights the scene, but is
/// itself black to the camera, as in Mitsuba, because no light path connects it to the lens.
/// Surfaces behind a mask or a pane are black. `flip_invalid_normals` may turn a normal map's
/// normal toward the viewer: mirrors then send no light to viewers that see the turned normal.
///
/// Camera rays find a film's alpha, as in `path`.
///
///     <integrator type="ptracer"><integer name="max_depth" value="3"/></integrator>

#include <algorithm>
#include <optional>

#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/light_paths/light_paths.h"
#include "transport/paths/camera_block.h"
#include "transport/stages.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_PATH_PARAMETERS,
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera sees emitters as black surfaces, which hide the objects behind them."},
};

/// Maximum number of light paths in a pass, unless one sample of each pixel is more. It bounds the
/// memory of splats that wait to be added to the film.
constexpr uint64_t kMaxPathsPerPass = uint64_t{1} << 20;

/// State of one thread.
struct LightTracingWorker {
  LightTracingWorker(const transport::SceneTable& scene, const Sensor& sensor,
                     const PathSettings& settings)
      : paths(scene, sensor, settings.length, settings.hide_emitters, transport::kBlockSamples) {
    if (sensor.film().has_alpha()) camera.emplace(scene, sensor, settings);
  }

  void trace(const PixelSamples& samples, Tile& tile) {
    paths.trace(samples, tile);
    if (!camera) return;
    {
      const StageTimer timer(tile.counters.stage_seconds["primary"]);
      camera->begin(samples, tile.counters);
    }
    const StageTimer timer(tile.counters.stage_seconds["film"]);
    for (float* column : {camera->radiance().x, camera->radiance().y, camera->radiance().z}) {
      std::fill_n(column, samples.count(), 0.f);
    }
    camera->end(samples, tile.film, tile.counters);
  }

  transport::LightPaths paths;
  std::optional<transport::CameraBlock> camera;  ///< finds alpha; nullopt if the film has none
};

class LightTracingIntegrator final : public Integrator {
 public:
  explicit LightTracingIntegrator(const Properties& props)
      : length_(props), hide_emitters_(props.boolean("hide_emitters")) {}

  std::vector<Stage> stages() const override {
    return {{"emit", "samples rays from emitters"}, kBounceStage, kShadeStage, kShadowStage,
            kPrimaryStage, kFilmStage};
  }

  bool gives_samples() const override { return false; }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) {
      warn_without_emitters(scene);
      context.job.skip("light paths", "the scene has no emitters");
      return;
    }
    if (length_.max_depth == 0) {
      context.job.skip("light paths", "max_depth is 0: the image is black");
      return;
    }
    const transport::SceneTable table(scene);
    transport::Workers<LightTracingWorker> workers;
    const auto make = [&] {
      return std::make_unique<LightTracingWorker>(table, sensor,
                                                  PathSettings{length_, hide_emitters_});
    };
    const uint64_t seed = key_seed(context.job, sensor.sampler());
    const uint32_t count = sensor.sampler().sample_count();
    Film& film = sensor.film();
    const auto pixels = static_cast<uint64_t>(std::max(1, film.crop().area()));
    const auto step =
        static_cast<uint32_t>(std::clamp<uint64_t>(kMaxPathsPerPass / pixels, 1, count));
    for (uint32_t done = 0; done < count && !context.job.cancelled(); done += step) {
      const uint32_t of_pass = std::min(step, count - done);
      context.job.set_progress_range(static_cast<double>(done) / count,
                                     static_cast<double>(done + of_pass) / count);
      context.scheduler.for_each_tile(film, [&](Tile& tile) {
        workers.with_one(make, [&](LightTracingWorker& worker) {
          transport::for_each_block(tile.pixels, done, of_pass, seed,
                                    [&](const PixelSamples& samples) {
                                      context.job.check_interrupt();
                                      worker.trace(samples, tile);
                                    });
        });
        // Counted for each tile, so that a cancelled render has the right brightness for the paths
        // traced so far.
        tile.film.add_light_paths(static_cast<double>(tile.pixels.area()) * of_pass);
      });
    }
    context.job.set_progress_range(0, 1);
  }

 private:
  PathLength length_;
  bool hide_emitters_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::LightTracingIntegrator, kinome::Category::kIntegrator, "ptracer",
              "Light tracing: paths from the emitters, each point of which is connected to the "
              "sensor.",
              kinome::kTable);

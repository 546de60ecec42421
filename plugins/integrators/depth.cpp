/// Distance of the first hit along the ray, from the camera's near plane (as in Mitsuba), in all
/// three colour channels. 0 if the ray hits nothing.
///
///     <integrator type="depth"/>

#include "ignored_parameters.h"
#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {kIgnoredHideEmitters};

/// State of one thread.
class DepthWorker {
 public:
  DepthWorker(const transport::SceneTable& scene, const Sensor& sensor)
      : camera_(scene, sensor, transport::kBlockSamples, false),
        film_(sensor.film().filter(), sensor.film().value_count(0), transport::kBlockSamples,
              true),
        arena_(transport::kBlockSamples + kBlockLanes),
        depth_{arena_.floats(), arena_.floats(), arena_.floats()},
        alpha_(arena_.floats()),
        values_{depth_.x, depth_.y, depth_.z} {
    if (sensor.film().has_alpha()) values_.push_back(alpha_);
  }

  void render(const PixelSamples& samples, Tile& tile) {
    const StageTimer timer(tile.counters.stage_seconds["primary"]);
    camera_.trace_rays(samples, tile.counters);
    for (size_t i = 0; i < samples.count(); ++i) {
      depth_.set(i, Vec3(camera_.hit(i) ? camera_.depth(i) : 0.f));
    }
    camera_.find_alpha(alpha_);
    film_.add(samples, camera_.film_position(), values_, tile.film);
  }

 private:
  transport::Camera camera_;
  transport::FilmSamples film_;
  transport::Arena arena_;
  Columns3 depth_;
  float* alpha_;
  std::vector<float*> values_;
};

class DepthIntegrator final : public Integrator {
 public:
  explicit DepthIntegrator(const Properties&) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    context.job.skip("shading", "only distances are needed");
    const transport::SceneTable table(scene);
    transport::render_tiles<DepthWorker>(
        sensor, context, 0, [&] { return std::make_unique<DepthWorker>(table, sensor); },
        [](DepthWorker& worker, const PixelSamples& samples, Tile& tile) {
          worker.render(samples, tile);
        });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(
    kinome::DepthIntegrator, kinome::Category::kIntegrator, "depth",
    "Distance of the first hit along the ray, from the near plane; 0 if the ray hits nothing.",
    kinome::kTable);

/// Distance of the first hit along the ray, from the camera's near plane (as in Mitsuba), in all
/// three colour channels; 0 where there is none.
///
///     <integrator type="depth"/>

#include <array>
#include <span>

#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"

namespace kinome {
namespace {

constexpr std::array<Parameter, 0> kTable{};

constexpr uint32_t kRays = 4096;  ///< traced together

class DepthIntegrator final : public Integrator {
 public:
  explicit DepthIntegrator(const Properties&) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    context.skip("shading", "only distances are asked for");
    const auto value_count = static_cast<size_t>(sensor.film().value_count(0));
    const uint64_t seed = key_seed(context, sensor.sampler());
    const uint32_t samples_per_pixel = sensor.sampler().sample_count();
    const auto render_part = [&](Tile& tile, uint32_t first, uint32_t samples) {
      thread_local PrimaryBatch primary;
      const StageTimer timer(tile.counters.stage_seconds["primary"]);
      primary.trace(scene, sensor, tile.pixels, first, samples, seed, tile.counters);
      for (size_t i = 0; i < primary.size(); ++i) {
        const float t = primary.hit(i) ? primary.depth(i) : 0;
        const std::array<float, 4> values{t, t, t, primary.hit(i) ? 1.f : 0.f};
        tile.film.add(primary.film_position(i), std::span(values.data(), value_count));
      }
    };
    for_each_sample_range(context, samples_per_pixel, [&](uint32_t begin, uint32_t count) {
      context.for_each_tile(sensor.film(), [&](Tile& tile) {
        for_each_part(tile.pixels, count, kRays, [&](uint32_t first, uint32_t samples) {
          render_part(tile, begin + first, samples);
        });
      });
    });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(
    kinome::DepthIntegrator, kinome::Category::kIntegrator, "depth",
    "Distance of the first hit along the ray, from the near plane; 0 where there is none.",
    kinome::kTable);

// Entry points of product sampling. They choose the method and render by it.
#include <optional>

#include "clustered/product/method/method_choice.h"
#include "clustered/product/pass/product_renderer.h"
#include "kinome/clustered_light.h"

namespace kinome {

bool is_product_scene(const Scene& scene, uint32_t max_depth) {
  const Emitter* const environment = scene.environment();
  return (!environment || cell_grid_of(*environment)) && LocalLight::serves(scene, max_depth);
}

void render_product(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    CellsOnDemand cells, const ProductSettings& settings) {
  const TileGrid grid(sensor.film().sampled());
  const RenderLength length = expected_length(settings, sensor, context, kInfinity);
  const MethodChoice choice =
      choose_method(scene, sensor, context, cells, settings, length, grid);
  if (choice.paths) {
    choice.paths->render(choice.paths->samples());
    return;
  }
  if (context.cancelled()) return;
  ProductRenderer renderer(scene, sensor, context, cells.get(context), settings, grid);
  if (choice.map) renderer.use(*choice.map, choice.paths_per_ray);
  renderer.render_all();
}

namespace {

/// A renderer with the objects that must outlive it.
struct ProductPasses final : Passes {
  const TileGrid grid;
  MethodChoice choice;
  std::optional<ProductRenderer> renderer;

  explicit ProductPasses(const Sensor& sensor) : grid(sensor.film().sampled()) {}
  double samples() const override { return renderer->samples(); }
  double render(double samples) override { return renderer->render(samples); }
  double seconds_per_sample() const override { return renderer->seconds_per_sample(); }
};

}  // namespace

std::unique_ptr<Passes> begin_product(const Scene& scene, const Sensor& sensor,
                                      RenderContext& context, CellsOnDemand cells,
                                      const ProductSettings& settings, double seconds) {
  context.begin_pass(0, 0, 0);  // the share of the trial and the pilot in the progress isn't known
  const RenderLength length = expected_length(settings, sensor, context, seconds);
  auto passes = std::make_unique<ProductPasses>(sensor);
  MethodChoice& choice = passes->choice;
  choice = choose_method(scene, sensor, context, cells, settings, length, passes->grid);
  if (choice.paths) return std::move(choice.paths);
  ProductRenderer& renderer = passes->renderer.emplace(
      scene, sensor, context, cells.get(context), settings, passes->grid);
  if (choice.map) renderer.use(*choice.map, choice.paths_per_ray);
  if (length.seconds == kInfinity) {
    renderer.learn_from_pilot(length.rays_per_pixel);
  } else if (const double speed = choice.rays_per_second > 0
                                     ? choice.rays_per_second
                                     : kCarefulSpeed * context.all_threads();
             !renderer.learn_in_time(seconds, speed) && renderer.can_use_paths() &&
             is_path_possible(scene, sensor, settings)) {
    return path_passes(scene, sensor, context, settings, 1,
                       "without a pilot, paths from the camera do better");
  }
  return passes;
}

}  // namespace kinome

#include "clustered/product/method/product_method.h"

#include <algorithm>
#include <string>

#include "clustered/product/method/method_choice.h"
#include "clustered/product/pass/product_renderer.h"
#include "kinome/clustered_light.h"
#include "kinome/log.h"

namespace kinome {
namespace {

/// Maximum number of cells of an environment if there is local light. Together, they must not
/// exceed kMaxCells.
constexpr uint32_t kMaxCellsWithLocalLight = 1u << 14;

/// Below this number of rays per pixel, computing the cells of each patch takes much of the time.
constexpr double kMaxRaysForFewerCells = 40;

/// True if the emitters have all functions that paths of up to max_depth edges require.
bool is_product_scene(const Scene& scene, uint32_t max_depth) {
  const Emitter* const environment = scene.environment();
  return (!environment || cell_grid_of(*environment)) && LocalLight::serves(scene, max_depth);
}

}  // namespace

bool ProductMethod::is_for_light_points(const Settings& settings,
                                        std::span<const Emitter* const> emitters) {
  if (settings.sampling.length.max_depth <= 2) return false;
  const bool chosen = std::any_of(emitters.begin(), emitters.end(), [](const Emitter* emitter) {
    return emitter->is_indirect() && !emitter->children().empty();
  });
  return chosen || settings.max_geometry_term > 0;
}

bool ProductMethod::serves(const Settings& settings, const Scene& scene) {
  return !scene.emitters().empty() && !is_for_light_points(settings, scene.indirect_emitters()) &&
         is_product_scene(scene, settings.sampling.length.max_depth);
}

std::unique_ptr<const ProductMethod> ProductMethod::make(const Settings& settings,
                                                         const Scene& scene, const Sensor& sensor,
                                                         RenderContext& context,
                                                         bool is_progressive) {
  ProductSettings sampling = settings.sampling;
  if (!(sampling.rays_per_pixel > 0)) {
    sampling.rays_per_pixel = kRaysPerSample * sensor.sampler().sample_count();
  }
  if (scene.emitters().empty()) return nullptr;
  if (!is_product_scene(scene, sampling.length.max_depth)) {
    const bool is_bounce = sampling.length.max_depth > 2 && is_product_scene(scene, 2);
    log_warn(std::string("an emitter lacks a function that importance 'product' requires") +
             (is_bounce ? " for reflected light (emission_density; not required with max_depth 2)"
                        : "") +
             (sampling.groups.is_empty() ? ": using 'joint', which is slower" : ": using 'path'"));
    return nullptr;
  }
  if (is_for_light_points(settings, scene.indirect_emitters())) return nullptr;
  const Emitter* const environment = scene.environment();
  const bool alone = environment && scene.emitters().size() == 1 && sampling.length.max_depth == 2;
  uint32_t count = alone ? settings.cells : std::min(settings.cells, kMaxCellsWithLocalLight);
  // In scenes of few primitives, visibility is learned from few rays. Most of the error is in cells
  // that straddle a horizon, so that small cells are better.
  if (sampling.fewer_cells && !is_progressive && sampling.rays_per_pixel < kMaxRaysForFewerCells &&
      !has_few_primitives(scene)) {
    count = std::max(count / 2, 1u);
  }
  const Cells cells = [environment, count, &context,
                       made = std::shared_ptr<const DistantCells>()]() mutable {
    if (!made && !environment) made = std::make_shared<DistantCells>();
    if (!made) {
      const StageTimer timer(context.job.stats().counters.stage_seconds["cells"]);
      made = std::make_shared<DistantCells>(*environment, *cell_grid_of(*environment), count,
                                            context.scheduler);
    }
    return made;
  };
  if (alone && cells()->size() == 0) return nullptr;
  return std::make_unique<const ProductMethod>(sampling, cells);
}

void ProductMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  const ProductTask task(scene, sensor, context, sampling_);
  MethodChoice choice = choose_method(task, cells_, expected_length(task, kInfinity));
  if (choice.paths) {
    choice.paths->render(choice.paths->samples());
    return;
  }
  if (context.job.cancelled()) return;
  ProductRenderer renderer{task, cells_(), make_local_light(task)};
  renderer.use(std::move(choice.map), choice.paths_per_ray);
  renderer.render_all();
}

std::unique_ptr<Passes> ProductMethod::begin(const Scene& scene, const Sensor& sensor,
                                             RenderContext& context, double seconds) const {
  // The share of the trial and the pilot in the progress isn't known.
  context.job.begin_pass(0, 0, 0);
  const ProductTask task(scene, sensor, context, sampling_);
  const RenderLength length = expected_length(task, seconds);
  MethodChoice choice = choose_method(task, cells_, length);
  if (choice.paths) return std::move(choice.paths);
  std::unique_ptr<ProductRenderer> renderer(
      new ProductRenderer{task, cells_(), make_local_light(task)});
  renderer->use(std::move(choice.map), choice.paths_per_ray);
  if (length.seconds == kInfinity) {
    renderer->learn_from_pilot(length.rays_per_pixel);
  } else if (const double speed = choice.rays_per_second > 0
                                      ? choice.rays_per_second
                                      : kRaysPerThreadSecond * context.scheduler.all_threads();
             !renderer->learn_in_time(seconds, speed) && renderer->can_use_paths() &&
             is_path_possible(task)) {
    return path_passes(task, 1, "without a pilot, path has less noise");
  }
  return renderer;
}

}  // namespace kinome

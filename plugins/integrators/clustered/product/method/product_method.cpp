#include "clustered/product/method/product_method.h"

#include <algorithm>
#include <string>

#include "kinome/clustered_light.h"
#include "kinome/log.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

namespace kinome {
namespace {

/// Maximum number of cells of an environment if there is local light. Together, they must not
/// exceed kMaxCells.
constexpr uint32_t kMaxCellsBesideLocal = 1u << 14;

/// Below this number of rays per pixel, computing the cells of each patch takes much of the time.
constexpr double kFewRays = 40;
constexpr size_t kMaxPrimitives = 1000;

/// True if the scene needs light points, because light of only some emitters bounces or
/// max_geometry_term bounds it.
bool is_for_light_points(const ProductMethod::Settings& settings, const Scene& scene) {
  if (settings.sampling.length.max_depth <= 2) return false;
  const auto& indirect = scene.indirect_emitters();
  const bool chosen = std::any_of(indirect.begin(), indirect.end(),
                                  [](const Emitter* e) { return !e->children().empty(); });
  return chosen || settings.max_geometry_term > 0;
}

}  // namespace

bool has_few_primitives(const Scene& scene) {
  size_t count = 0;
  for (const auto& shape : scene.shapes()) {
    count += shape->mesh() ? shape->mesh()->triangles.size() : 1;
  }
  return count < kMaxPrimitives;
}

bool ProductMethod::serves(const Settings& settings, const Scene& scene) {
  return !scene.emitters().empty() && !is_for_light_points(settings, scene) &&
         is_product_scene(scene, settings.sampling.length.max_depth);
}

std::unique_ptr<const ProductMethod> ProductMethod::make(const Settings& settings,
                                                         const Scene& scene, double rays_per_pixel,
                                                         RenderContext& context) {
  const ProductSettings& sampling = settings.sampling;
  if (scene.emitters().empty()) return nullptr;
  if (!is_product_scene(scene, sampling.length.max_depth)) {
    const bool is_bounce = sampling.length.max_depth > 2 && is_product_scene(scene, 2);
    log_warn(std::string("an emitter lacks a function that importance 'product' requires") +
             (is_bounce ? " for reflected light (emission_density; not required with max_depth 2)"
                        : "") +
             ": using 'joint', which is slower");
    return nullptr;
  }
  if (is_for_light_points(settings, scene)) return nullptr;
  const Emitter* const environment = scene.environment();
  if (!environment) {
    return std::unique_ptr<const ProductMethod>(
        new ProductMethod(sampling, std::make_shared<const DistantCells>()));
  }
  const bool alone = scene.emitters().size() == 1 && sampling.length.max_depth == 2;
  uint32_t count = alone ? settings.cells : std::min(settings.cells, kMaxCellsBesideLocal);
  // In scenes of few primitives, visibility is learned from few rays. Most of the error is in cells
  // that straddle a horizon, so that small cells are better.
  if (sampling.fewer_cells && rays_per_pixel < kFewRays && !has_few_primitives(scene)) {
    count = std::max(count / 2, 1u);
  }
  CellsOnDemand cells([environment, count](RenderContext& own) {
    const StageTimer timer(own.stats().counters.stage_seconds["cells"]);
    return std::make_shared<const DistantCells>(*environment, *cell_grid_of(*environment), count,
                                                own);
  });
  if (alone && cells.get(context)->size() == 0) return nullptr;
  return std::unique_ptr<const ProductMethod>(new ProductMethod(sampling, std::move(cells)));
}

double ProductMethod::rays_per_pixel(const Settings& settings, const Sensor& sensor) {
  const double rays = settings.sampling.rays_per_pixel;
  return rays > 0 ? rays : kRaysPerSample * sensor.sampler().sample_count();
}

ProductSettings ProductMethod::sampling_of(const Sensor& sensor) const {
  ProductSettings settings = sampling_;
  settings.rays_per_pixel = rays_per_pixel({settings}, sensor);
  return settings;
}

void ProductMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  render_product(scene, sensor, context, cells_, sampling_of(sensor));
}

std::unique_ptr<Passes> ProductMethod::begin(const Scene& scene, const Sensor& sensor,
                                             RenderContext& context, double seconds) const {
  return begin_product(scene, sensor, context, cells_, sampling_of(sensor), seconds);
}

std::vector<Inspection> ProductMethod::inspect(const Scene& scene, const Sensor& sensor,
                                               RenderContext& context, int x, int y) const {
  CellsOnDemand cells = cells_;
  return inspect_product(scene, sensor, context, cells.get(context), sampling_of(sensor), x, y);
}

}  // namespace kinome

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "clustered/product/pass/product_renderer.h"
#include "clustered/product/trial/path_tiles.h"
#include "kinome/log.h"

namespace kinome {
namespace {

/// Maximum number of rays per pixel of a pass. Each pass draws new points of the cells.
constexpr double kMaxRaysOfPass = 512;
/// Number of rays of the image per light point.
constexpr double kRaysPerPoint = 32, kRaysPerExtendedPoint = 16;
/// Rays per pixel that are assumed if a render ends at an error.
constexpr double kAssumedRaysPerPixel = 100;
/// Assumed number of passes of a render that ends at a time or an error.
constexpr double kPassesOfBudget = 3;
/// Number of light points per seen position, and the minimum number of positions, for learning
/// which points contribute.
constexpr uint32_t kPointsPerPosition = 8, kMinPositions = 256;
/// Candidates per ray if there was no pilot.
constexpr double kUnlearnedCandidatesPerRay = 16;
/// Separates the random numbers of passes from those of the pilot.
constexpr uint64_t kPassSeed = 0x70617373;
constexpr uint64_t kCausticSeed = 0x63617573;
constexpr uint64_t kPathSeed = 0x70617468;
constexpr std::span<const Bsdf* const> kNoPhases{};

/// Returns the sensor with a sampler of about `paths` samples per pixel. Samplers round numbers up:
/// accepts up to a quarter more.
std::unique_ptr<Sensor> with_paths(const Sensor& sensor, double paths) {
  const auto wanted = static_cast<uint32_t>(std::clamp(paths, 1., 1e6));
  for (uint32_t count = wanted;; count -= std::max(1u, count / 8)) {
    auto result = sensor.with_sample_count(count);
    if (count == 1 || result->sampler().sample_count() <= wanted * 5 / 4) return result;
  }
}

}  // namespace

RenderLength expected_length(const ProductTask& task, double seconds) {
  const RenderBudget& budget = task.context.job.budget();
  const double pixels = std::max(1, task.grid.crop().area());
  if (budget.seconds > 0) {
    return {seconds * kRaysPerThreadSecond * task.context.scheduler.all_threads() / pixels,
            seconds};
  }
  return {budget.rel_mse > 0 ? kAssumedRaysPerPixel : task.settings.rays_per_pixel};
}

ProductRenderer::ProductRenderer(const ProductTask& task, std::shared_ptr<const DistantCells> cells,
                                 std::unique_ptr<const LocalLight> local, double light_share)
    : task_(task),
      context_(task.context),
      grid_(task_.grid),
      table_(task.scene),
      shared_cells_(std::move(cells)),
      cells_(*shared_cells_),
      light_share_(light_share),
      local_(std::move(local)),
      addresses_(task.scene),
      knowledge_(grid_, cells_, local_.get(), task_.settings),
      rays_left_(task.settings.rays_per_pixel) {
  if (local_ && (local_->has_lamp_caustics() || local_->has_extended_caustics())) {
    RenderCounters& counters = task.context.job.stats().counters;
    const StageTimer timer(counters.stage_seconds["cells"]);
    caustics_.emplace(task.scene, task.sensor, *local_,
                      transport::hides_environment(task.path_settings(), task.scene), task.seed,
                      counters);
    if (!caustics_->finds_any()) caustics_.reset();
  }
}

std::unique_ptr<const LocalLight> make_local_light(const ProductTask& task, double share,
                                                   double min_aimed_share) {
  const auto& [scene, sensor, context, settings, grid, seed] = task;
  const size_t others = scene.emitters().size() - (scene.environment() ? 1 : 0);
  if (others == 0 && settings.length.max_depth < LocalLight::kBounceDepth) return nullptr;
  const StageTimer timer(context.job.stats().counters.stage_seconds["cells"]);
  LocalLight::Settings local;
  local.length = settings.length;
  local.bounce_cells = settings.bounce_cells;
  local.min_aimed_share = min_aimed_share;
  local.groups = settings.groups;
  local.caustics = Caustics::serves(sensor) && !task.divides_light();
  if (task.divides_light() && Caustics::serves(sensor) &&
      LocalLight::may_have_lamp_caustics(scene)) {
    log_warn(
        "with light groups, 'clustered' leaves out light that lamps send to other surfaces by way "
        "of mirrors or smooth glass (caustics)");
    context.job.skip("caustics", "paths from the emitters aren't divided by light group");
  }
  // If rays are few, points must be, too: each takes about as long as two rays. A render that ends
  // at an error is assumed to have many rays. Each pass draws the same number of extended points.
  double rays = settings.rays_per_pixel * sensor.film().crop().area(), parts = 1;
  if (context.job.budget().any()) {
    const double seconds = context.job.budget().seconds;
    rays =
        seconds > 0 ? seconds * kRaysPerThreadSecond * context.scheduler.all_threads() : kInfinity;
    parts = kPassesOfBudget;
  }
  rays = share * std::min(rays, kMaxRaysOfPass * sensor.film().crop().area());
  local.points = static_cast<uint32_t>(
      std::clamp<double>(rays / kRaysPerPoint, LocalLight::kMinPoints, LocalLight::kMaxPoints));
  local.extended_points = static_cast<uint32_t>(
      std::min<double>(rays / (kRaysPerExtendedPoint * parts), LocalLight::kMaxExtendedPoints));
  std::vector<SurfaceInteraction> seen;
  if (settings.light_guide &&
      (scene.has_surface_emitters() || settings.length.max_depth >= LocalLight::kBounceDepth)) {
    seen = places_seen(scene, sensor, std::max(kMinPositions, local.points / kPointsPerPosition),
                       seed, context);
  }
  auto light = std::make_unique<const LocalLight>(scene, local, seen, seed, context);
  return light->empty() && light->is_complete() ? nullptr : std::move(light);
}

Primaries::View ProductRenderer::view() const {
  Primaries::View view{table_, task_.sensor, task_.path_settings()};
  // Mirrors may show any light, which paths find by emitter and BSDF samples.
  view.follows_mirrors = local_ != nullptr;
  return view;
}

PassView ProductRenderer::pass_view(const CellLight& light) const {
  return {task_, view(), knowledge_, neighbours_, light};
}

struct ProductRenderer::Pass {
  CellLight light;
  uint64_t seed;
  float weight;
  /// Sensor of the tiles that are left to `path`; nullptr if there are none.
  std::unique_ptr<Sensor> path_sensor;
};

struct ProductRenderer::PassWorker {
  BlockRenderer product;
  std::optional<PathTiles> paths;

  PassWorker(const PassView& view, const transport::SceneTable& path_scene,
             const Sensor* path_sensor, const PathSettings& settings)
      : product(view) {
    if (path_sensor) paths.emplace(path_scene, *path_sensor, settings);
  }
};

void ProductRenderer::pass(const Pass& pass, std::span<const PixelPlan> plan) {
  grid_.for_each_block<PassWorker>(
      context_.scheduler, grid_.all_rows(), "main",
      [&] {
        return std::make_unique<PassWorker>(pass_view(pass.light),
                                            grouped_table_ ? *grouped_table_ : table_,
                                            pass.path_sensor.get(), task_.path_settings());
      },
      [&](int block, PassWorker& worker, RenderCounters& counters) {
        if (!context_.job.is_wanted(grid_.block(block), task_.sensor.film().first_layer())) return;
        worker.product.render(block, plan, pass.seed, counters, [&](const TileGrid::Tile& tile) {
          context_.job.check_interrupt();
          return !is_by_path(tile);
        });
        add_to_film(pass, block, worker, counters);
      });
}

/// Adds the block to the film at once, so that an interrupted render contains all finished blocks.
void ProductRenderer::add_to_film(const Pass& pass, int block, PassWorker& worker,
                                  RenderCounters& counters) {
  Film& film = task_.sensor.film();
  const Rect pixels = grid_.block(block);
  std::vector<FilmTile> tiles;
  for (int layer = 0; layer < (task_.settings.diagnostics ? 2 : 1); ++layer) {
    tiles.push_back(film.make_tile(pixels, layer));
  }
  FilmTile& colours = tiles[0];
  if (worker.paths) {
    const uint32_t count = pass.path_sensor->sampler().sample_count();
    worker.paths->trace(
        grid_, block, count, hash_words(pass.seed, kPathSeed), counters,
        [&](const TileGrid::Tile& tile) { return is_by_path(tile); },
        [&](const PixelSamples& samples, transport::CameraBlock& camera) {
          context_.job.check_interrupt();
          camera.end(samples, colours, counters, pass.weight / static_cast<float>(count));
        });
  }
  const StageTimer timer(counters.stage_seconds["film"]);
  worker.product.add_to(colours, pass.weight);
  if (task_.settings.diagnostics) {
    size_t next = 0;
    grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      tile.for_each_pixel([&](int x, int y) {
        const Vec3& d = worker.product.diagnostics(next++);
        tiles[1].add_pixel(x, y, std::array{d.x, d.y, d.z}, pass.weight);
      });
    });
  }
  if (caustics_) {
    const double paths = std::ceil(pass.weight * unit_ / kRaysPerCausticPath * pixels.area());
    caustics_->trace(hash_words(pass.seed, static_cast<uint64_t>(block), kCausticSeed),
                     static_cast<uint32_t>(paths), colours, counters);
  }
  context_.scheduler.commit(film, static_cast<size_t>(block), std::move(tiles));
}

CellLight ProductRenderer::make_light(uint64_t seed, double rays_per_pixel, float share) const {
  const StageTimer timer(context_.job.stats().counters.stage_seconds["points"]);
  const uint64_t own = hash_words(task_.seed, seed);
  CellPoints points;
  if (cells_.size() > 0) {
    points = cells_.draw_points(CellLight::points_for(rays_per_pixel * grid_.crop().area()), own,
                                context_.scheduler);
  }
  LocalPoints local_points;
  if (local_) local_points = local_->draw(hash_words(own, 1), context_, share);
  CellLight light(cells_, task_.scene.environment(), std::move(points), local_.get(),
                  std::move(local_points));
  light.paths = task_.path_settings();
  light.caustics = caustics_ ? &*caustics_ : nullptr;
  light.horizon_terms = task_.settings.control_variate && task_.settings.horizon_terms;
  return light;
}

void ProductRenderer::use(std::unique_ptr<const MethodMap> map, double paths_per_ray) {
  map_ = std::move(map);
  paths_per_ray_ = paths_per_ray;
}

void ProductRenderer::divide_among_methods() {
  if (!map_) return;
  if (task_.divides_light()) grouped_table_.emplace(task_.scene, kNoPhases, task_.settings.groups);
  by_path_.resize(static_cast<size_t>(grid_.tiles()));
  context_.scheduler.parallel_for(by_path_.size(), [&](size_t tile) {
    const auto index = static_cast<int>(tile);
    by_path_[tile] = map_->is_for_path(index, knowledge_.main_bsdf(index)) ? 1 : 0;
  });
}

LargeArray<PixelPlan> ProductRenderer::plan_pass(double rays_per_pixel) const {
  const StageTimer timer(context_.job.stats().counters.stage_seconds["allocate"]);
  if (allocation_) {
    return allocation_->plan(rays_per_pixel, context_.scheduler);
  }
  PixelPlan plan;
  plan.primaries = static_cast<uint16_t>(std::max(1., rays_per_pixel / 3));
  plan.rays = static_cast<uint16_t>(std::max(1., rays_per_pixel - plan.primaries));
  plan.candidates = static_cast<float>(kUnlearnedCandidatesPerRay * plan.rays);
  return LargeArray<PixelPlan>(static_cast<size_t>(grid_.crop().area()), plan);
}

/// Uses as few passes as possible: the more rays share a comb, the more precise is each of them.
void ProductRenderer::render_rays(double rays_per_pixel, double progress_begin, bool is_last) {
  const auto passes =
      static_cast<uint64_t>(std::max(1., std::ceil(rays_per_pixel / kMaxRaysOfPass)));
  // Rays besides caustics. The paths of caustics are a fixed share of these.
  const double of_caustics = caustics_ ? caustics_->rays_per_path() / kRaysPerCausticPath : 0;
  const double rays = rays_per_pixel / static_cast<double>(passes) / (1 + of_caustics);
  const LargeArray<PixelPlan> plan = plan_pass(rays);
  if (is_last) allocation_.reset();  // a large part of the memory of a large image
  if (unit_ == 0) unit_ = std::max(rays, 1.);
  const auto weight = static_cast<float>(std::max(rays, 1.) / unit_);
  for (uint64_t i = 0; i < passes && !context_.job.cancelled(); ++i, ++pass_) {
    const double part = (1 - progress_begin) / static_cast<double>(passes);
    const double begin = progress_begin + part * static_cast<double>(i);
    context_.job.set_progress_range(begin, begin + part);
    Pass own{make_light(1 + pass_, rays), hash_words(task_.seed, kPassSeed, pass_), weight,
             nullptr};
    if (task_.divides_light()) own.light.divide_by(task_.settings.groups);
    if (!by_path_.empty()) own.path_sensor = with_paths(task_.sensor, paths_per_ray_ * rays);
    pass(own, plan);
  }
  context_.job.set_progress_range(0, 1);
}

double ProductRenderer::samples() const {
  return rays_left_ / kRaysPerSample;
}

double ProductRenderer::render(double samples) {
  render_rays(kRaysPerSample * samples, 0, false);
  return samples;
}

void ProductRenderer::render_all() {
  learn_from_pilot(task_.settings.rays_per_pixel);
  const double total = std::max(task_.settings.rays_per_pixel, 1.);
  if (!context_.job.cancelled())
    render_rays(rays_left_, std::max(0., 1 - rays_left_ / total), true);
}

}  // namespace kinome

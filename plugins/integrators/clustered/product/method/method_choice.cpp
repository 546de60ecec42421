#include "clustered/product/method/method_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "clustered/product/tiles/spread.h"
#include "clustered/product/trial/method_trial.h"
#include "clustered/product/trial/path_tiles.h"
#include "kinome/log.h"
#include "kinome/process_group.h"
#include "transport/paths/path_integrator.h"

namespace kinome {
namespace {

constexpr uint64_t kTrialSeed = 0x74726961;
/// Work is counted in rays of `path`. A ray of product sampling, with all computations for it,
/// costs this many. 4 to 6 were measured in most scenes, and 7 to 10 in scenes of few primitives,
/// where the rays of `path` are fast. Counts of rays don't depend on the machine, unlike seconds.
constexpr double kCostOfRay = 5, kCostAmongFewPrimitives = 8;
/// Renders of less work are left to `path`, because a trial would take more than a tenth of it.
constexpr double kMinWork = 4.5e6;
/// Short renders are left to product sampling from this number of emitters on, because `path`
/// samples one emitter at a time.
constexpr size_t kMinEmitters = 500;
/// Direct light of emitters without area is left to `path` if there are fewer rays per pixel: hardly
/// anything can be learned from them.
constexpr double kMinRaysOfDirectLight = 8;
/// Share of the render's work that the tiles of a trial take, and the work of one tile.
constexpr double kShareOfTiles = 0.04, kWorkOfTile = 8500;
constexpr int kMaxTiles = 256;
/// Number of tiles by which the work of `path` is estimated if a render ends at an error.
constexpr int kTilesForError = 64;
/// Maximum share of the time for a trial. It takes about 0.05 on an idle machine, and more if other
/// programs run.
constexpr double kTrialShare = 0.25;
/// The rest of a trial takes up to this many times as long as its pilot. It must not take more than
/// this share of the time that is left for the trial.
constexpr double kTimePerPilotTime = 5, kMaxShareOfTimeLeft = 0.7;
/// Fraction of a render's light points that each render of a trial draws.
constexpr double kLightShare = 0.125;
constexpr double kMaxRaysOfTrial = 32;  ///< of product sampling, per pixel
/// Both methods share an image if that takes less than this fraction of the work of either alone.
constexpr double kMaxWorkOfTiles = 0.9;
/// A trial ends after one render by product sampling, of all tiles or of a part, if `path` takes
/// less work by this factor.
constexpr double kClearRatio = 2.5, kClearRatioOfPart = 4;
/// Maximum expected deviation of the brightness by product sampling. Renders that exceed it are
/// left to `path`. Most trials of a dozen interiors find less than 0.02.
constexpr double kMaxDeviation = 0.025;
/// Minimum fraction of the light that is aimed at what the camera sees. Below it, there is no
/// trial: light points of the other light are rare and bright, and two renders seldom show them.
constexpr double kMinAimedShare = 0.1;
/// Paths per sample of product sampling if no trial measures their costs.
constexpr double kPathsPerSample = 3;
/// Number of paths per pixel of a trial's render by `path`.
constexpr uint32_t kTrialPaths = 16;
constexpr size_t kMaxPrimitives = 1000;

/// Passes of `path`. A sample is a path.
class PathPasses final : public Passes {
 public:
  PathPasses(const ProductTask& task, double paths_per_sample)
      : integrator_(task.path_settings(), task.settings.groups),
        paths_(integrator_.begin(task.scene, task.sensor, task.context, kInfinity)),
        samples_(
            rounded(std::max(1., task.settings.rays_per_pixel / kRaysPerSample * paths_per_sample),
                    task.sensor.sampler().sample_count())) {}

  double samples() const override { return samples_; }
  double render(double samples) override {
    const double paths = paths_->render(samples);
    log_debug(fmt::format("path: {:.0f} paths per pixel", paths));
    return paths;
  }
  double seconds_per_sample() const override { return paths_->seconds_per_sample(); }

 private:
  /// Rounds to a power of two if the scene's sample count is one: samplers of low discrepancy are
  /// best at these counts.
  static double rounded(double samples, uint32_t scene_samples) {
    return std::has_single_bit(scene_samples) ? std::exp2(std::round(std::log2(samples))) : samples;
  }

  const transport::PathIntegrator integrator_;
  const std::unique_ptr<Passes> paths_;
  const double samples_;
};

/// Result of a trial.
struct Measured {
  /// nullptr if hardly any light is aimed at what the camera sees. Nothing else is measured then.
  std::unique_ptr<const MethodMap> map;
  double paths_per_ray = 0;    ///< number of paths that cost as much as a ray of product sampling
  double deviation = 0;        ///< MethodTrial::Result::deviation
  double rays_per_second = 0;  ///< of product sampling
};

/// Returns true if `path` takes less work than both methods together, and less than product
/// sampling by `factor`.
bool is_for_path(const MethodMap& map, double factor) {
  const double paths = map.path_work();
  return factor * paths < map.product_work() && paths < map.mixed_work() / kMaxWorkOfTiles;
}

constexpr const char* kProductSampling = "product sampling";

bool has_bounces(const ProductTask& task) {
  return task.settings.length.max_depth >= LocalLight::kBounceDepth;
}

/// Returns why an image for which is_path_possible() is false needs product sampling.
const char* why_not_path(const ProductTask& task) {
  if (!task.settings.trial) return "the parameter 'trial' is false";
  if (task.settings.diagnostics) return "diagnostics were requested";
  return has_bounces(task) ? "paths from the camera don't find all light of this scene"
                           : "its cells contain all light of this scene";
}

/// True if all light comes directly from emitters without area, and the render is too short for
/// product sampling.
bool is_short_render_of_direct_light(const ProductTask& task, const RenderLength& length) {
  return task.settings.trial && !task.settings.diagnostics && !has_bounces(task) &&
         !task.scene.has_surface_emitters() && task.scene.emitters().size() < kMinEmitters &&
         length.rays_per_pixel < kMinRaysOfDirectLight;
}

/// Returns the method that renders by kTrialPaths paths of `path` per pixel, with the sensor's
/// sampler. The arguments must outlive the result.
MethodTrial::Way way_of_paths(const ProductTask& task, const transport::SceneTable& table,
                              uint64_t seed, uint64_t stream) {
  const auto trace = [&task, &table, seed, stream](const MethodTrial& tiles, uint64_t index,
                                                   std::span<Rgb> image) {
    const auto set_means = [&](const PixelSamples& samples, const transport::CameraBlock& camera) {
      for (size_t p = 0; p < samples.pixels; ++p) {
        Rgb sum(0.f);
        for (uint32_t k = 0; k < kTrialPaths; ++k) sum += camera.radiance().at(p * kTrialPaths + k);
        const auto x = static_cast<int32_t>(samples.x[p]), y = static_cast<int32_t>(samples.y[p]);
        image[task.grid.pixel(x, y)] = sum / static_cast<float>(kTrialPaths);
      }
    };
    tiles.for_each_tile<PathTiles>(
        task.context.scheduler, image,
        [&] { return std::make_unique<PathTiles>(table, task.sensor, task.path_settings()); },
        [&](int chosen, PathTiles& paths, RenderCounters& counters) {
          paths.trace(
              task.grid, task.grid.block_of(chosen), kTrialPaths, hash_words(seed, stream, index),
              counters, [&](const TileGrid::Tile& tile) { return tile.index == chosen; },
              set_means);
        });
  };
  return {trace};
}

/// Returns the rays per pixel with which `path` is expected to reach an error, measured in some
/// tiles.
double path_rays_to_error(double rel_mse, const ProductTask& task, uint64_t seed) {
  const MethodTrial tiles(task.grid, kTilesForError, hash_words(seed, 3),
                          PixelFilter(task.sensor.film().filter()));
  if (tiles.empty()) return 0;
  const transport::SceneTable table(task.scene);
  const MethodTrial::RenderError found =
      tiles.measure(way_of_paths(task, table, seed, 4), task.context);
  const double rays = found.cost / static_cast<double>(tiles.pixels().size());
  return rays * std::max(found.rel_mse / rel_mse, 1. / kTrialPaths);
}

/// Runs the trial, with fewer tiles if all of them would take too long. Returns nullopt if product
/// sampling must render the image, or if the render was cancelled.
std::optional<Measured> try_both(const ProductTask& task, const ProductMethod::Cells& cells,
                                 const RenderLength& length, MethodTrial trial, double deadline,
                                 uint64_t seed) {
  RenderContext& context = task.context;
  auto local = make_local_light(task, kLightShare, kMinAimedShare);
  if (local && !local->is_complete()) return Measured{};
  ProductRenderer product(task, cells(), std::move(local), kLightShare);
  const double rays = std::clamp(length.rays_per_pixel, 1., kMaxRaysOfTrial);
  if (!product.can_use_paths()) return std::nullopt;
  if (product.aimed_share() < kMinAimedShare) return Measured{};
  const double cost = has_few_primitives(task.scene) ? kCostAmongFewPrimitives : kCostOfRay;
  const double start = context.job.seconds();
  const double pilot_rays = product.learn_for_trial(length.rays_per_pixel, trial);
  if (deadline < kInfinity) {
    const double now = context.job.seconds();
    trial.keep(agree(context.job.group(),
                     kMaxShareOfTimeLeft * (deadline - now) / (kTimePerPilotTime * (now - start))));
  }
  MethodTrial::Way product_way = product.trial_way(trial, rays, length, cost, seed);
  double seconds = 0;
  product_way.render = [&, render = product_way.render](const MethodTrial& tiles, uint64_t index,
                                                        std::span<Rgb> image) {
    const double begin = context.job.seconds();
    render(tiles, index, image);
    seconds += context.job.seconds() - begin;
  };
  const transport::SceneTable table(task.scene);
  const MethodTrial::Way path_way = way_of_paths(task, table, seed, 2);
  // The pilot's rays are taken from those of the image.
  const double share_of_image =
      std::max(0.1, 1 - pilot_rays / std::max(length.rays_per_pixel, 1.));
  const double scale = 1 / (share_of_image * product.aimed_share());
  const auto map_of = [&](const MethodTrial::Result& result) {
    std::vector<MethodMap::Trial> trials;
    for (const MethodTrial::TileErrors& tile : result.tiles) {
      trials.push_back({tile.tile, product.main_bsdf(tile.tile), tile.first * scale,
                        tile.second * result.cost});
    }
    return std::make_unique<const MethodMap>(trial.grid(), std::move(trials));
  };
  const MethodTrial::Result result =
      trial.compare(product_way, path_way, context, [&](const MethodTrial::Result& first) {
        const bool is_part = first.tiles.size() * kTileSide * kTileSide < trial.pixels().size();
        return is_for_path(*map_of(first), is_part ? kClearRatioOfPart : kClearRatio);
      });
  if (context.job.cancelled() || result.tiles.empty()) return std::nullopt;
  return Measured{map_of(result), kTrialPaths / (result.cost * rays), result.deviation,
                  2 * rays * static_cast<double>(trial.pixels().size()) / seconds};
}

}  // namespace

bool has_few_primitives(const Scene& scene) {
  size_t count = 0;
  for (const auto& shape : scene.shapes()) {
    count += shape->mesh() ? shape->mesh()->triangles.size() : 1;
  }
  return count < kMaxPrimitives;
}

bool is_path_possible(const ProductTask& task) {
  if (!task.settings.trial || task.settings.diagnostics) return false;
  if (!has_bounces(task)) return task.scene.has_surface_emitters();
  if (!Caustics::serves(task.sensor) || task.divides_light()) return true;
  return !LocalLight::may_have_lamp_caustics(task.scene);
}

std::unique_ptr<Passes> path_passes(const ProductTask& task, double paths_per_sample,
                                    const std::string& reason) {
  task.context.job.skip("product", reason);
  report_method(task.context, "path", reason);
  return std::make_unique<PathPasses>(task, paths_per_sample);
}

namespace {

/// Returns the better method according to a trial, and reports it.
MethodChoice choose_by_trial(const ProductTask& task, Measured measured) {
  RenderContext& context = task.context;
  const double product = measured.map->product_work(), paths = measured.map->path_work();
  const double mixed = measured.map->mixed_work();
  log_debug(fmt::format("trial: work to the same error by product sampling 1, by path {:.3g}, by "
                        "tiles of both {:.3g}{}",
                        paths / product, mixed / product,
                        measured.deviation > 0
                            ? fmt::format("; brightness by product sampling uncertain by {:.1f} %",
                                          100 * measured.deviation)
                            : ""));
  const double paths_per_sample = std::max(1., measured.paths_per_ray * kRaysPerSample);
  const auto by_path = [&](const char* reason) {
    return MethodChoice{path_passes(task, paths_per_sample, reason), nullptr};
  };
  if (measured.deviation > kMaxDeviation) {
    return by_path("in a trial, the brightness by product sampling was too uncertain");
  }
  if (is_for_path(*measured.map, 1)) {
    return by_path("in a trial, path took less work for the same error");
  }
  MethodChoice choice;
  if (mixed < kMaxWorkOfTiles * product) {
    choice.map = std::move(measured.map);
    report_method(context, "product sampling and path, by tiles",
                  fmt::format("in a trial, the mix took {:.2g} times the work of product sampling "
                              "alone, and path {:.2g} times",
                              mixed / product, paths / product));
  } else {
    report_method(context, kProductSampling,
                  fmt::format("in a trial, path took {:.2g} times the work for the same error",
                              paths / product));
  }
  choice.paths_per_ray = measured.paths_per_ray;
  choice.rays_per_second = agree(context.job.group(), measured.rays_per_second);
  return choice;
}

}  // namespace

MethodChoice choose_method(const ProductTask& task, const ProductMethod::Cells& cells,
                           const RenderLength& length) {
  RenderContext& context = task.context;
  const auto by_product = [&](const std::string& reason) {
    report_method(context, kProductSampling, reason);
    return MethodChoice{};
  };
  const auto by_path = [&](double paths_per_sample, const char* reason) {
    return MethodChoice{path_passes(task, paths_per_sample, reason), nullptr};
  };
  if (is_short_render_of_direct_light(task, length)) {
    return by_path(kPathsPerSample, "there are too few rays per pixel to learn from");
  }
  if (!is_path_possible(task)) return by_product(why_not_path(task));
  const uint64_t seed = hash_words(task.seed, kTrialSeed);
  double work = length.rays_per_pixel * task.grid.crop().area() * kCostOfRay;
  if (const double rel_mse = context.job.budget().rel_mse; rel_mse > 0) {
    work = std::min(work, task.grid.crop().area() * path_rays_to_error(rel_mse, task, seed));
  }
  const auto tiles = static_cast<int>(
      std::clamp<double>(work * kShareOfTiles / kWorkOfTile, MethodTrial::kMinTiles, kMaxTiles));
  const MethodTrial trial(task.grid, tiles, seed, PixelFilter(task.sensor.film().filter()));
  const bool is_short = work < kMinWork || trial.empty();
  if (is_short && task.scene.emitters().size() >= kMinEmitters) {
    return by_product("the render is short, and path samples only one of many emitters at a time");
  }
  if (is_short) {
    return by_path(kPathsPerSample, "the render is short, and path needs no preparation");
  }
  const double deadline = context.job.seconds() + kTrialShare * length.seconds;
  context.job.set_deadline(deadline);
  auto measured = try_both(task, cells, length, trial, deadline, seed);
  const bool is_late = context.job.cancelled() && !context.job.interrupted();
  context.job.set_deadline(kInfinity);
  if (is_late) return by_path(1, "there was too little time for a trial");
  if (!measured) return by_product("path finds some of the light poorly or not at all");
  if (!measured->map) {
    return by_path(kPathsPerSample, "most light doesn't reach what the camera sees");
  }
  return choose_by_trial(task, std::move(*measured));
}

}  // namespace kinome

#include "clustered/media/media_method.h"

#include <algorithm>
#include <memory>

#include "clustered/media/fog_block.h"
#include "clustered/media/media_trial.h"
#include "kinome/error.h"
#include "kinome/stats.h"
#include "transport/blocks_of_tile.h"

namespace kinome {
namespace {

constexpr const char* kVolpath = "volpath";
constexpr const char* kWhyGrids = "the scene has media that vary in space";

/// True if some medium varies.
bool has_grids(const Scene& scene) {
  return std::any_of(scene.media().begin(), scene.media().end(),
                     [](const Medium* medium) { return !medium->is_uniform(); });
}

/// True if the film's alpha depends on light that goes straight through surfaces. FogBlock doesn't
/// follow alpha behind them.
bool has_alpha_behind_surfaces(const Scene& scene, const Sensor& sensor, bool hide_emitters) {
  if (!sensor.film().has_alpha() || (scene.environment() && !hide_emitters)) return false;
  return std::any_of(scene.shapes().begin(), scene.shapes().end(), [](const auto& shape) {
    return shape->bsdf().passes_straight() && !shape->bsdf().is_invisible();
  });
}

}  // namespace

MediaMethod::MediaMethod(const PathSettings& settings, bool has_trial)
    : settings_(settings), has_trial_(has_trial), paths_(settings) {}

std::unique_ptr<Passes> MediaMethod::begin(const Scene& scene, const Sensor& sensor,
                                           RenderContext& context, double seconds) const {
  const bool has_light = settings_.length.max_depth > 0 && !scene.emitters().empty();
  // With media and light, the result doesn't refer to paths_, which it may outlive.
  if (!has_grids(scene) || !has_light) return nullptr;
  report_method(context, kVolpath, kWhyGrids);
  return paths_.begin(scene, sensor, context, seconds);
}

void MediaMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  if (has_grids(scene) || settings_.length.max_depth < 2 || scene.emitters().empty() ||
      has_alpha_behind_surfaces(scene, sensor, settings_.hide_emitters)) {
    report_method(context, kVolpath,
                  has_grids(scene) ? kWhyGrids : "candidates in media don't suit this scene");
    return paths_.render(scene, sensor, context);
  }
  const transport::MediaTable media(scene, sensor);
  const bool starts_enclosed =
      media.start() != transport::MediaTable::kVacuum && media.emitter_weight(media.start()) != 1;
  if (starts_enclosed) {
    report_method(context, kVolpath, "the camera is inside of a medium with a surface");
    return paths_.render(scene, sensor, context);
  }
  const transport::SceneTable table(scene, media.phases());
  std::unique_ptr<const FogSources> sources;
  {
    const StageTimer timer(context.job.stats().counters.stage_seconds["cells"]);
    sources = std::make_unique<const FogSources>(scene, context.scheduler);
  }
  if (has_trial_ && prefers_paths(table, media, *sources, sensor, settings_, context)) {
    const char* const reason = "paths from the camera alone do as well in the media for less";
    context.job.skip("product", reason);
    report_method(context, kVolpath, reason);
    return paths_.render(scene, sensor, context);
  }
  report_method(context, "candidates in media",
                has_trial_ ? "in a trial, volpath took more work for the same error"
                           : "the parameter 'trial' is false");
  transport::render_tiles<FogBlock>(
      sensor, context, 0,
      [&] { return std::make_unique<FogBlock>(table, media, *sources, sensor, settings_); },
      [](FogBlock& block, const PixelSamples& samples, Tile& tile) {
        block.render(samples, tile);
      });
}

std::vector<Inspection> MediaMethod::inspect(const Scene& scene, const Sensor& /*sensor*/,
                                             RenderContext& /*context*/, int /*x*/,
                                             int /*y*/) const {
  throw Error(Location{scene.file()}, "cannot inspect: the scene has media");
}

}  // namespace kinome

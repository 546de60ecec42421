#include "clustered/media/media_method.h"

#include "clustered/media/media_render.h"
#include "kinome/error.h"

namespace kinome {

MediaMethod::MediaMethod(const PathSettings& settings, bool has_trial)
    : settings_(settings), has_trial_(has_trial), paths_(settings) {}

std::unique_ptr<Passes> MediaMethod::begin(const Scene& scene, const Sensor& sensor,
                                           RenderContext& context, double seconds) const {
  const char* const why_paths = MediaRender::why_paths(scene, sensor, settings_);
  if (!why_paths) return media_passes(scene, sensor, settings_, has_trial_, context);
  const bool has_light = settings_.length.max_depth > 0 && !scene.emitters().empty();
  if (!has_light) return nullptr;
  report_method(context, kVolpath, why_paths);
  // With media and light, the result doesn't refer to paths_, which it may outlive.
  return paths_.begin(scene, sensor, context, seconds);
}

void MediaMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  if (const char* const why = MediaRender::why_paths(scene, sensor, settings_)) {
    report_method(context, kVolpath, why);
    return paths_.render(scene, sensor, context);
  }
  MediaRender render(scene, sensor, settings_, has_trial_, context);
  render.choose(sensor);
  render.render(sensor);
}

std::vector<Inspection> MediaMethod::inspect(const Scene& scene, const Sensor& /*sensor*/,
                                             RenderContext& /*context*/, int /*x*/,
                                             int /*y*/) const {
  throw Error(Location{scene.file()}, "cannot inspect: the scene has media");
}

}  // namespace kinome

#include "clustered/media/media_method.h"

#include <utility>

#include "clustered/media/media_render.h"
#include "kinome/error.h"

namespace kinome {

MediaMethod::MediaMethod(const PathSettings& settings, bool has_trial, LightGroups groups)
    : settings_(settings),
      has_trial_(has_trial),
      has_groups_(!groups.is_empty()),
      paths_(settings) {
  paths_.set_light_groups(std::move(groups));
}

/// Returns why `volpath` renders the scene, or nullptr if it needn't.
const char* MediaMethod::why_paths(const Scene& scene, const Sensor& sensor) const {
  if (has_groups_) return "light groups were requested, which candidates in media don't divide";
  return MediaRender::why_paths(scene, sensor, settings_);
}

std::unique_ptr<Passes> MediaMethod::begin(const Scene& scene, const Sensor& sensor,
                                           RenderContext& context, double seconds) const {
  const char* const why = why_paths(scene, sensor);
  if (!why) return media_passes(scene, sensor, settings_, has_trial_, context);
  const bool has_light = settings_.length.max_depth > 0 && !scene.emitters().empty();
  if (!has_light) return nullptr;
  report_method(context, kVolpath, why);
  // With media and light, the result doesn't refer to paths_, which it may outlive.
  return paths_.begin(scene, sensor, context, seconds);
}

void MediaMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  if (const char* const why = why_paths(scene, sensor)) {
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

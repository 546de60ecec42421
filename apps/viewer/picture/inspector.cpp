#include "picture/inspector.h"

#include <cmath>
#include <type_traits>

#include "drawing/inspection_image.h"
#include "kinome/object_description.h"
#include "kinome/render_context.h"

namespace kinome::viewer {
namespace {

/// Returns the scene's own settings of `clustered`, with this importance function.
ObjectDescription integrator_of(const SceneEditor& editor, const std::string& importance) {
  ObjectDescription description{
      .tag = "integrator", .type = "clustered", .where = {"the inspector"}};
  description.values.push_back({"importance", importance, description.where});
  for (const SceneParameter& parameter : editor.parameters()) {
    if (parameter.plugin != "integrator/clustered" || !parameter.is_set || !parameter.value)
      continue;
    const std::string name = parameter.path.substr(parameter.path.rfind('.') + 1);
    if (name == "importance") continue;
    std::visit(
        [&](const auto& value) {
          if constexpr (std::is_constructible_v<Properties::Value, decltype(value)>) {
            description.values.push_back({name, value, description.where});
          }
        },
        *parameter.value);
  }
  return description;
}

InspectedSet draw(Inspection report, const Scene& scene, const Sensor& sensor) {
  drawing::InspectionView view = drawing::inspection_view(report, scene, sensor);
  InspectionMarks marks = marks_of(report, sensor);
  return {std::move(report), std::move(view.canvas.image), std::move(marks)};
}

}  // namespace

InspectedPixel inspect_pixel(SceneEditor& editor, const Sensor& sensor, unsigned threads,
                             const Vec2& pixel, const std::string& importance) {
  InspectedPixel found{glm::floor(pixel), importance, {}, {}};
  try {
    const auto scene = editor.scene_with(integrator_of(editor, importance));
    RenderContext context({.threads = threads});
    for (Inspection& report :
         scene->integrator().inspect(*scene, sensor, context, found.pixel + 0.5f)) {
      found.sets.push_back(draw(std::move(report), *scene, sensor));
    }
    if (found.sets.empty()) found.fault = drawing::kNoLightPoints;
  } catch (const std::exception& fault) {
    found.sets.clear();
    found.fault = fault.what();
  }
  return found;
}

}  // namespace kinome::viewer

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/scene_editor.h"
#include "picture/inspection_marks.h"

namespace kinome::viewer {

/// Samples of a pixel from one set of light points: see InspectionView.
struct InspectedSet {
  Inspection report;
  Image picture;  ///< linear RGB: a map of all directions for distant light, otherwise the scene
  InspectionMarks marks;
};

/// Inspection of the integrator `clustered` at a pixel. Immutable once it is made.
struct InspectedPixel {
  Vec2 pixel{0.f};         ///< of the film
  std::string importance;  ///< "joint", "luminance", "brdf" or "product"
  std::vector<InspectedSet> sets;
  std::string fault;  ///< error message if `sets` is empty, otherwise ""
};

/// Inspects a pixel with this importance function. All other settings are those of the scene's
/// integrator, if that is `clustered`. Doesn't write to the sensor's film. Takes some tenths of a
/// second. Doesn't throw; errors are in InspectedPixel::fault.
InspectedPixel inspect_pixel(SceneEditor& editor, const Sensor& sensor, unsigned threads,
                             const Vec2& pixel, const std::string& importance);

}  // namespace kinome::viewer

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/scene_editor.h"
#include "picture/inspection_marks.h"

namespace kinome::viewer {

/// Where a pixel's samples go, for one set of light points: see InspectionView.
struct InspectedSet {
  Inspection report;
  Image picture;  ///< linear R, G, B: of distant light a map of all directions, else of the scene
  InspectionMarks marks;
};

/// What an integrator `clustered` does at a pixel. Immutable once it is made.
struct InspectedPixel {
  Vec2 pixel{0.f};         ///< of the film
  std::string importance;  ///< "joint", "luminance", "brdf" or "product"
  std::vector<InspectedSet> sets;
  std::string fault;  ///< why there are none; "": there are
};

/// Inspects a pixel by that importance function and else by the settings of the scene's own
/// integrator, where that is `clustered`. The sensor's film isn't written to. Takes some tenths of
/// a second. Throws nothing.
InspectedPixel inspect_pixel(SceneEditor& editor, const Sensor& sensor, unsigned threads,
                             const Vec2& pixel, const std::string& importance);

}  // namespace kinome::viewer

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/scene_editor.h"
#include "kinome/sensor.h"

namespace kinome::viewer {

/// Marks of an inspection that are drawn over the image of the scene, in pixels of the sensor's
/// film. Parts outside the camera's view are left out.
struct InspectionMarks {
  struct Line {
    Vec2 from, to;
    bool is_lit;  ///< false if the sample is occluded
  };
  /// Edge of a cluster's bounding box.
  struct Edge {
    Vec2 from, to;
    float share;  ///< probability of the cluster, divided by the largest one
  };
  std::optional<Vec2> point;  ///< the inspected surface point
  /// Lines from the point to the samples. For distant light they have a seventh of the length from
  /// the camera to the point.
  std::vector<Line> lines;
  std::vector<Edge> edges;  ///< boxes of the 200 most probable clusters of local light

  /// Adds an offset on the film to all marks.
  void move(const Vec2& offset);
};

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

#pragma once

#include <optional>
#include <vector>

#include "kinome/inspection.h"
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
InspectionMarks marks_of(const Inspection& report, const Sensor& sensor);

}  // namespace kinome::viewer

#pragma once

#include <optional>
#include <vector>

#include "kinome/inspection.h"
#include "kinome/sensor.h"

namespace kinome::viewer {

/// What of an inspection is drawn over the picture of the scene itself, in pixels of the sensor's
/// film; without what the camera doesn't see.
struct InspectionMarks {
  struct Line {
    Vec2 from, to;
    bool is_lit;  ///< or shadowed
  };
  struct Edge {  ///< of a cluster's box
    Vec2 from, to;
    float share;  ///< the cluster's probability by that of the likeliest
  };
  std::optional<Vec2> point;  ///< that is lit
  /// Of distant light: from the point toward the samples, a seventh as long as the camera is away.
  /// Of local light: from the point to the samples.
  std::vector<Line> lines;
  std::vector<Edge> edges;  ///< of local light's clusters that are chosen, the likeliest 200

  /// By an offset on the film.
  void move(const Vec2& offset);
};
InspectionMarks marks_of(const Inspection& report, const Sensor& sensor);

}  // namespace kinome::viewer

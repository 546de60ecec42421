#pragma once

#include "kinome/color.h"

namespace kinome {

/// What a pilot finds out about one of its primaries, for the plan; radiances.
struct PointPlan {
  /// Unshadowed radiance of glossy lobes, and of all lobes from local light that has an extent, of
  /// the group that it is in.
  float glossy = 0;
  float lamps = 0;  ///< of its own, unshadowed, from those lamps that no ray asked for
  /// Gets what it sees of the other lamps, when their rays are traced; nullptr: nobody asks.
  float* lit = nullptr;
  /// Gets what the path finds that goes on from it, if one does (Estimator::follow_paths).
  Rgb* followed = nullptr;
  double glossy_variance = 0;  ///< of one candidate; in float, bright light's would overflow
  float mirrored = 0;          ///< unshadowed, by delta lobes
};

}  // namespace kinome

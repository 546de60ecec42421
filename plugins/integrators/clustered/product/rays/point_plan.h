#pragma once

#include "kinome/color.h"

namespace kinome {

/// Results of the pilot for one of its primaries, used by the plan. Values are radiances.
struct PointPlan {
  /// Unshadowed radiance that the primary's group reflects: by glossy lobes, and by all lobes for
  /// local light except that of lamps.
  float glossy = 0;
  float lamps = 0;  ///< unshadowed radiance of the primary, from lamps that got no ray
  /// Receives the radiance that arrives from the other lamps, when their rays are traced; may be
  /// nullptr.
  float* lit = nullptr;
  /// Receives the light that the primary's path finds, if one continues from it
  /// (Estimator::follow_paths).
  Rgb* followed = nullptr;
  double glossy_variance = 0;  ///< of one candidate; bright light would overflow a float
  float mirrored = 0;          ///< unshadowed radiance that delta lobes reflect
};

}  // namespace kinome

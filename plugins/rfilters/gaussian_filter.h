#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/math.h"

namespace kinome {

/// The filter ends after this many standard deviations.
inline constexpr float kGaussianCutoff = 4.f;

/// exp(-x²/2s²), lowered so that it reaches zero at the cutoff.
inline float gaussian_filter(float x, float stddev) {
  const float at_cutoff = std::exp(-0.5f * sqr(kGaussianCutoff));
  return std::max(0.f, std::exp(-0.5f * sqr(x / stddev)) - at_cutoff);
}

}  // namespace kinome

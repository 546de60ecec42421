#pragma once

#include <cstdint>
#include <vector>

namespace kinome {

/// What the pilot expects of one pixel, in the unit of radiance: squares of it would leave single
/// precision where light is as bright or as faint as it may be.
struct PixelForecast {
  float mean = 0;              ///< radiance
  float deviation = 0;         ///< of a primary's radiance, its light being known
  float uncertainty = 0;       ///< of a primary: sum over strata, the scale of its rays' noise
  float glossy_deviation = 0;  ///< of one unshadowed candidate
  bool sharp = false;          ///< reflects by a sharp lobe: forecasts of single pixels are noise
  float mirrors = 0;  ///< rays that each camera ray takes besides: of mirrors, and eye rays
};

/// What one pixel gets in a pass.
struct PixelPlan {
  uint16_t primaries = 0;
  uint16_t rays = 0;
  float candidates = 0;
};

/// Divides `rays_per_pixel` (primaries and shadow rays) among pixels, so that relative errors are
/// about alike.
std::vector<PixelPlan> allocate(const std::vector<PixelForecast>& forecast, int width, int height,
                                double rays_per_pixel, bool adaptive);

}  // namespace kinome

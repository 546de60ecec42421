#pragma once

#include <cstdint>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "kinome/wide/numbers.h"

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

/// Divides rays among the pixels of a picture, so that relative errors are about alike. Immutable.
class RayAllocation {
 public:
  enum class Mode {
    kEven,      ///< all get about the same
    kAdaptive,  ///< what is expected of each says
    kSmoothed   ///< what is expected around it says, too: forecasts of few primaries are noisy
  };
  /// By what is expected of width x height pixels.
  RayAllocation(const std::vector<PixelForecast>& forecast, int width, int height, Mode mode);

  /// Of primaries and shadow rays together, on average.
  std::vector<PixelPlan> plan(double rays_per_pixel) const;

 private:
  wide::Float primaries(size_t i, float scale, float least) const;
  wide::Float rays(size_t i, float scale) const;
  wide::Float candidates(size_t i, float scale) const;
  double total(float scale, float least_primaries) const;

  size_t width_, height_;
  size_t stride_;  ///< of the columns' rows
  /// What each pixel asks for, but for a common factor.
  Column<float> primaries_, rays_, candidates_;
  Column<float> costs_;  ///< of a primary, with the mirrors' rays
};

}  // namespace kinome

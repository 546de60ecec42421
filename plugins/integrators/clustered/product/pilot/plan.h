#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "kinome/wide/numbers.h"
#include "transport/blocks/large_array.h"

namespace kinome {

class Scheduler;

/// The pilot's forecast for one pixel. All fields have the unit of radiance, because squares of
/// very bright or faint light exceed the range of a float.
struct PixelForecast {
  float mean = 0;              ///< radiance
  float deviation = 0;         ///< standard deviation of primaries, without noise of their light
  float uncertainty = 0;       ///< of a primary: sum over strata, the scale of its rays' noise
  float glossy_deviation = 0;  ///< of one unshadowed candidate
  bool sharp = false;          ///< true if lobes are sharp: the forecast of a single pixel is noise
  float mirrors = 0;           ///< additional rays per camera ray: mirrored rays and eye rays
};

/// Numbers of rays of one pixel in a pass.
struct PixelPlan {
  uint16_t primaries = 0;
  uint16_t rays = 0;
  float candidates = 0;
};

/// Distributes rays over the pixels of an image so that their relative errors are similar.
/// Immutable.
class RayAllocation {
 public:
  enum class Mode {
    kEven,      ///< nearly the same numbers for all pixels
    kAdaptive,  ///< by the forecast of each pixel
    kSmoothed   ///< by the forecasts of neighbours, too, because those of few primaries are noisy
  };
  /// Uses the forecasts of width x height pixels.
  RayAllocation(std::span<const PixelForecast> forecast, int width, int height, Mode mode,
                const Scheduler& scheduler);

  /// Returns the plan whose mean number of primaries and shadow rays per pixel is `rays_per_pixel`.
  LargeArray<PixelPlan> plan(double rays_per_pixel, const Scheduler& scheduler) const;

 private:
  /// Number of scales whose totals are computed together: those of two steps of a bisection.
  static constexpr size_t kScales = 3;

  wide::Float primaries(size_t i, float scale, float min_primaries) const;
  wide::Float rays(size_t i, float scale, float min_rays) const;
  wide::Float candidates(size_t i, float scale) const;
  std::array<double, kScales> totals(const std::array<float, kScales>& scales, float min_primaries,
                                     float min_rays, const Scheduler& scheduler) const;
  /// Number of parts of the image that threads process, and the first row of a part.
  size_t parts() const;
  size_t first_row(size_t part) const { return part * height_ / parts(); }

  size_t width_, height_;
  size_t stride_;  ///< of the columns' rows
  /// Numbers of each pixel, except for a common factor.
  Column<float> primaries_, rays_, candidates_;
  Column<float> costs_;  ///< rays per primary, including mirrored rays
};

}  // namespace kinome

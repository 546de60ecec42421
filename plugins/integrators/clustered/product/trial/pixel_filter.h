#pragma once

#include <array>

#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Reconstruction filter for the means of whole pixels. Has weights of a pixel and its neighbours,
/// for samples that are spread evenly over each pixel. Filters noise that neighbouring pixels share
/// as the film does. Immutable.
class PixelFilter {
 public:
  /// Neighbours farther away, in pixels, are ignored.
  static constexpr int kReach = 2;

  /// Box filter as wide as a pixel, which doesn't change images.
  PixelFilter() { weights_[kReach] = 1; }
  explicit PixelFilter(const ReconstructionFilter& filter);

  float weight(int dx, int dy) const { return weights_[kReach + dx] * weights_[kReach + dy]; }
  /// Factor by which the filter changes the variance of noise that is independent between pixels.
  float variance() const;

 private:
  std::array<float, 2 * kReach + 1> weights_{};  ///< sum: 1
};

}  // namespace kinome

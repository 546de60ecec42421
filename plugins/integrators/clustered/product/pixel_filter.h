#pragma once

#include <array>

#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Reconstruction filter for the means of whole pixels: weights of a pixel and its neighbours, for
/// samples that are spread evenly over each pixel. Noise that neighbouring pixels share is filtered
/// as it is in an image. Immutable.
class PixelFilter {
 public:
  /// Neighbours farther away, in pixels, are ignored.
  static constexpr int kReach = 2;

  /// A box as wide as a pixel: images are left as they are.
  PixelFilter() { weights_[kReach] = 1; }
  explicit PixelFilter(const ReconstructionFilter& filter);

  float weight(int dx, int dy) const { return weights_[kReach + dx] * weights_[kReach + dy]; }
  /// Variance that is left of noise that pixels don't share.
  float variance() const;

 private:
  std::array<float, 2 * kReach + 1> weights_{};  ///< sum: 1
};

}  // namespace kinome

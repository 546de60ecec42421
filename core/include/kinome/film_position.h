#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/math.h"

namespace kinome {

/// Sample positions along one axis of a pixel. They are always less than the next pixel's edge, to
/// which the sum of pixel and u may be rounded up for large coordinates.
class PixelRange {
 public:
  explicit PixelRange(int pixel)
      : first_(static_cast<float>(pixel)), last_(std::nextafter(first_ + 1, first_)) {}
  /// Position of a sample at u in [0,1); F is float or wide::Float.
  template <class F>
  F at(const F& u) const {
    using std::min;
    return min(first_ + u, F(last_));
  }

 private:
  float first_, last_;
};
/// Returns the film position of a sample of pixel (x, y), for u in [0,1)².
inline Vec2 film_position(int x, int y, const Vec2& u) {
  return {PixelRange(x).at(u.x), PixelRange(y).at(u.y)};
}

}  // namespace kinome

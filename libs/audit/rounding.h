#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "kinome/color.h"
#include "kinome/math.h"

/// Compares values that were computed in two ways with unknown rounding errors.
namespace kinome {

/// Range of values that are acceptable for a function of a direction, if the direction has rounding
/// errors. It is the range of the function at neighbouring directions, extended by its own width to
/// either side, because the direction may be a peak or a dip between its neighbours. The range thus
/// adapts to steep slopes and discontinuities.
class ValueRange {
 public:
  void add(double value) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  /// Returns true if a value that was computed in another way is acceptable. Besides the range,
  /// this allows a relative error of 1e-3: about 100 rounding errors, magnified 100 times.
  bool agrees_with(double value) const {
    const double slack = slack_for(value);
    return value >= low_ - slack && value <= high_ + slack;
  }
  bool agrees_with(const ValueRange& other) const {
    const double slack =
        std::max(slack_for(other.low_), slack_for(other.high_)) + (other.high_ - other.low_);
    return other.high_ >= low_ - slack && other.low_ <= high_ + slack;
  }
  /// Adds `weight` >= 0 times the values of another range.
  void add_weighted(const ValueRange& other, double weight) {
    if (low_ > high_) low_ = high_ = 0;
    low_ += weight * other.low_;
    high_ += weight * other.high_;
  }

 private:
  double slack_for(double value) const {
    constexpr double kRelative = 1e-3;
    constexpr double kAbsolute = 1e-36;  // smaller products are denormal and lose precision
    const double max = std::max({std::abs(low_), std::abs(high_), std::abs(value)});
    return (high_ - low_) + kRelative * max + kAbsolute;
  }
  double low_ = INFINITY;
  double high_ = -INFINITY;
};

struct ColorRange {
  std::array<ValueRange, 3> channels;
  void add(const Rgb& color) {
    for (int c = 0; c < 3; ++c) channels[c].add(static_cast<double>(color[c]));
  }
  bool agrees_with(const Rgb& color) const {
    return channels[0].agrees_with(static_cast<double>(color.x)) &&
           channels[1].agrees_with(static_cast<double>(color.y)) &&
           channels[2].agrees_with(static_cast<double>(color.z));
  }
  bool agrees_with(const ColorRange& other) const {
    return channels[0].agrees_with(other.channels[0]) &&
           channels[1].agrees_with(other.channels[1]) && channels[2].agrees_with(other.channels[2]);
  }
  void add_weighted(const ColorRange& other, double weight) {
    for (int c = 0; c < 3; ++c) channels[c].add_weighted(other.channels[c], weight);
  }
};

/// Bound on the error of a direction of floats after about 12 operations, in radians: 32 times the
/// precision of float.
inline constexpr float kDirectionError = 0x1p-18f;

/// Returns a direction, four directions at an angle of two rounding errors (cells of a table may be
/// that narrow), and four at an angle of kDirectionError.
inline std::array<Vec3, 9> neighbours(const Vec3& d) {
  constexpr float kTwoRoundings = 0x1p-22f;
  const Frame frame = Frame::from_normal(d);
  std::array<Vec3, 9> found;
  found[0] = d;
  size_t i = 1;
  for (const float angle : {kTwoRoundings, kDirectionError}) {
    for (const Vec3& aside : {frame.s, -frame.s, frame.t, -frame.t}) {
      found[i++] = glm::normalize(d + aside * angle);
    }
  }
  return found;
}

/// Returns true if d has unit length. The tolerance is far larger than rounding errors and far
/// smaller than visible errors.
inline bool is_unit(const Vec3& d) {
  constexpr float kLengthError = 1e-4f;
  return std::abs(glm::dot(d, d) - 1) <= 2 * kLengthError;
}

}  // namespace kinome

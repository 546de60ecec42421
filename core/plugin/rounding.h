#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "kinome/color.h"
#include "kinome/math.h"

/// Whether two ways to compute one value agree, where both round and neither is known.
namespace kinome {

/// What a function of a direction may say of one that is known up to rounding: the range of its
/// values in the neighbourhood, and as much to either side (the direction itself may be a peak or a
/// dip, of which the neighbours see the slopes). However steep it is, or wherever it jumps, is thus
/// allowed for, and no more than that.
class ValueRange {
 public:
  void add(double value) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  /// Of a value that was computed otherwise. Besides, it may be off by 1e-3: some hundred
  /// roundings, magnified by as much.
  bool agrees_with(double value) const {
    const double slack = slack_for(value);
    return value >= low_ - slack && value <= high_ + slack;
  }
  bool agrees_with(const ValueRange& other) const {
    const double slack =
        std::max(slack_for(other.low_), slack_for(other.high_)) + (other.high_ - other.low_);
    return other.high_ >= low_ - slack && other.low_ <= high_ + slack;
  }
  /// Adds `weight` (not negative) times the values of another range.
  void add_weighted(const ValueRange& other, double weight) {
    if (low_ > high_) low_ = high_ = 0;
    low_ += weight * other.low_;
    high_ += weight * other.high_;
  }

 private:
  double slack_for(double value) const {
    constexpr double kRelative = 1e-3;
    constexpr double kLeast = 1e-36;  // products of less lose their digits to denormals
    const double most = std::max({std::abs(low_), std::abs(high_), std::abs(value)});
    return (high_ - low_) + kRelative * most + kLeast;
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

/// What angles of directions are known to, as floats, after a dozen of operations: 32 times their
/// precision.
inline constexpr float kDirectionError = 0x1p-18f;

/// A direction, four that are off by as much as two roundings (cells of a table may be as narrow),
/// and four that are off by kDirectionError.
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

/// Unit, up to far more than rounding, and far less than would be seen in a picture.
inline bool is_unit(const Vec3& d) {
  constexpr float kLengthError = 1e-4f;
  return std::abs(glm::dot(d, d) - 1) <= 2 * kLengthError;
}

}  // namespace kinome

#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

namespace kinome::viewer {

/// A rising function of a number as 256 levels, by table: level(x) is curve(x), clamped to [0,1],
/// times 255 and rounded, exactly, in a nanosecond or two whatever the curve is. Immutable.
class CurveTable {
 public:
  static constexpr int kLevels = 256;

  /// `curve` must not fall, over the floats >= 0.
  explicit CurveTable(const std::function<float(float)>& curve);

  /// Of what is negative or NaN: as of 0.
  uint8_t level(float x) const {
    if (!(x > 0)) return first_[0];
    const uint32_t bits = std::bit_cast<uint32_t>(x);
    uint32_t level = first_[bits >> kShift];
    // Few curves are so steep that there is a second one.
    while (level + 1 < kLevels && bits >= least_[level + 1]) ++level;
    return static_cast<uint8_t>(level);
  }

 private:
  /// Floats > 0 are ordered as their bits are: each run of them that share the upper bits knows the
  /// level of its first. 256 runs for each power of two.
  static constexpr int kShift = 15;
  std::array<uint32_t, kLevels> least_;
  std::vector<uint8_t> first_;
};

}  // namespace kinome::viewer

#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

namespace kinome::viewer {

/// Table of an increasing function with 256 levels. level(x) is exactly curve(x), clamped to [0,1],
/// times 255 and rounded. It takes one or two nanoseconds, independent of the curve. Immutable.
class CurveTable {
 public:
  static constexpr int kLevels = 256;

  /// `curve` must not decrease for floats >= 0.
  explicit CurveTable(const std::function<float(float)>& curve);

  /// Treats negative numbers and NaN as 0.
  uint8_t level(float x) const {
    if (!(x > 0)) return first_[0];
    const uint32_t bits = std::bit_cast<uint32_t>(x);
    uint32_t level = first_[bits >> kShift];
    // Only steep curves need more than one iteration.
    while (level + 1 < kLevels && bits >= min_bits_[level + 1]) ++level;
    return static_cast<uint8_t>(level);
  }

 private:
  /// Positive floats have the order of their bits. Floats with the same bits above kShift form a
  /// run, with 256 runs for each power of two.
  static constexpr int kShift = 15;
  std::array<uint32_t, kLevels> min_bits_;  ///< bits of the smallest float of each level
  std::vector<uint8_t> first_;              ///< level of the first float of each run
};

}  // namespace kinome::viewer

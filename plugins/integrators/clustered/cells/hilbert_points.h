#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// Returns the distance along a Hilbert curve through a square of 2^16 x 2^16.
uint32_t hilbert_index(uint32_t x, uint32_t y);

/// A point in a square, with 32 bits per coordinate. XORing each coordinate with a random number (a
/// digital shift) randomises it without changing the stratification of a set of points.
struct IntegerPoint {
  uint32_t x, y;
  Vec2 shifted(uint32_t shift_x, uint32_t shift_y) const;
};

/// Sobol points in the order of a Hilbert curve. Neighbours in the list are neighbours in the
/// square, so that stratified positions in the list are stratified in the square. Made on first
/// use; thread-safe.
class HilbertPoints {
 public:
  static constexpr uint32_t kMinLog2 = 4, kMaxLog2 = 11;
  static constexpr uint32_t kMaxCount = 256;

  static const HilbertPoints& get();
  /// Points as structure of arrays.
  struct Columns {
    std::span<const uint32_t> x, y;
    IntegerPoint operator[](size_t i) const { return {x[i], y[i]}; }
    size_t size() const { return x.size(); }
  };
  /// The first 2^log2 points, log2 <= kMaxLog2.
  Columns power_of_two(uint32_t log2) const {
    const auto& columns = powers_[log2];
    return {columns[0], columns[1]};
  }
  /// Returns the log2, from kMinLog2 to kMaxLog2, whose power of two is nearest to a number of
  /// points, by ratio.
  static uint32_t nearest_log2(double count);
  /// The first `count` points, 1 <= count <= kMaxCount.
  std::span<const IntegerPoint> first(uint32_t count) const { return firsts_[count]; }

 private:
  HilbertPoints();
  std::vector<std::array<std::vector<uint32_t>, 2>> powers_;  ///< x and y
  std::vector<std::vector<IntegerPoint>> firsts_;
};

}  // namespace kinome

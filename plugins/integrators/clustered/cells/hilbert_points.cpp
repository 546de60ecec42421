#include "clustered/cells/hilbert_points.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "kinome/wide/owen.h"

namespace kinome {
namespace {

constexpr uint64_t kScramble = 0x7c3f9a51d2e86b04u;

IntegerPoint sobol_point(uint32_t index) {
  return {owen_scramble(reverse_bits(index), kScramble),
          owen_scramble(reverse_bits(sobol_second_reversed(index)), ~kScramble)};
}

struct OrderedPoint {
  uint32_t key;    ///< distance along the curve
  uint32_t index;  ///< in the sequence
  IntegerPoint point;
};

/// Returns the first `count` points in the order of the curve.
std::vector<OrderedPoint> ordered_points(uint32_t count) {
  std::vector<OrderedPoint> points(count);
  for (uint32_t i = 0; i < count; ++i) {
    const IntegerPoint point = sobol_point(i);
    points[i] = {hilbert_index(point.x >> 16, point.y >> 16), i, point};
  }
  std::sort(points.begin(), points.end(),
            [](const OrderedPoint& a, const OrderedPoint& b) { return a.key < b.key; });
  return points;
}

}  // namespace

uint32_t HilbertPoints::nearest_log2(double count) {
  uint32_t log2 = kMinLog2;
  while (log2 < kMaxLog2 && (1u << log2) * std::numbers::sqrt2 < count) ++log2;
  return log2;
}

uint32_t hilbert_index(uint32_t x, uint32_t y) {
  uint32_t index = 0;
  for (uint32_t half = 1u << 15; half > 0; half >>= 1) {
    const bool right = x & half, upper = y & half;
    index = index << 2 | (right ? upper ? 2u : 3u : upper ? 1u : 0u);
    // The curve of each quarter is turned so that it begins where its neighbour's ends.
    if (!upper) {
      if (right) {
        x = ~x;
        y = ~y;
      }
      std::swap(x, y);
    }
  }
  return index;
}

Vec2 IntegerPoint::shifted(uint32_t shift_x, uint32_t shift_y) const {
  return {to_unit_float(x ^ shift_x), to_unit_float(y ^ shift_y)};
}

const HilbertPoints& HilbertPoints::get() {
  static const HilbertPoints points;
  return points;
}

HilbertPoints::HilbertPoints() {
  for (uint32_t log2 = 0; log2 <= kMaxLog2; ++log2) {
    auto& [x, y] = powers_.emplace_back();
    for (const OrderedPoint& ordered : ordered_points(1u << log2)) {
      x.push_back(ordered.point.x);
      y.push_back(ordered.point.y);
    }
  }
  const std::vector<OrderedPoint> all = ordered_points(kMaxCount);
  for (uint32_t count = 0; count <= kMaxCount; ++count) {
    auto& list = firsts_.emplace_back();
    for (const OrderedPoint& ordered : all) {
      if (ordered.index < count) list.push_back(ordered.point);
    }
  }
}

}  // namespace kinome

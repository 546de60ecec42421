#include "hilbert_points.h"

#include <algorithm>
#include <utility>

#include "kinome/owen.h"

namespace kinome {
namespace {

constexpr uint64_t kScramble = 0x7c3f9a51d2e86b04u;

IntegerPoint sobol_point(uint32_t index) {
  return {owen_scramble(reverse_bits(index), kScramble),
          owen_scramble(reverse_bits(sobol_second_reversed(index)), ~kScramble)};
}

std::vector<IntegerPoint> ordered_points(uint32_t count) {
  std::vector<IntegerPoint> points(count);
  for (uint32_t i = 0; i < count; ++i) points[i] = sobol_point(i);
  std::sort(points.begin(), points.end(), [](const IntegerPoint& a, const IntegerPoint& b) {
    return hilbert_index(a.x >> 16, a.y >> 16) < hilbert_index(b.x >> 16, b.y >> 16);
  });
  return points;
}

}  // namespace

uint32_t hilbert_index(uint32_t x, uint32_t y) {
  uint32_t index = 0;
  for (uint32_t half = 1u << 15; half > 0; half >>= 1) {
    const bool right = x & half, upper = y & half;
    index = index << 2 | (right ? upper ? 2u : 3u : upper ? 1u : 0u);
    // The quarter's own curve is turned, so that it begins where its neighbour's ends.
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
  for (uint32_t log2 = 0; log2 <= kMaxLog2; ++log2) powers_.push_back(ordered_points(1u << log2));
  firsts_.emplace_back();
  for (uint32_t count = 1; count <= kMaxCount; ++count) firsts_.push_back(ordered_points(count));
}

}  // namespace kinome

#include "picture/curve_table.h"

#include <algorithm>
#include <cmath>

namespace kinome::viewer {
namespace {

constexpr uint32_t kInfinityBits = 0x7f800000;

}  // namespace

CurveTable::CurveTable(const std::function<float(float)>& curve)
    : first_((uint32_t{1} << 31) >> kShift) {
  const auto level_of = [&](uint32_t bits) {
    const float value = curve(std::bit_cast<float>(bits));
    return static_cast<int>(std::lround(255 * std::clamp(value, 0.f, 1.f)));
  };
  min_bits_[0] = 0;
  for (int level = 1; level < kLevels; ++level) {
    uint32_t below = min_bits_[level - 1], above = kInfinityBits;
    if (level_of(below) >= level) {
      above = below;
    } else if (level_of(kInfinityBits - 1) < level) {
      below = above;
    }
    while (above > below + 1 && above != below) {  // level_of(below) < level <= level_of(above)
      const uint32_t middle = below + (above - below) / 2;
      (level_of(middle) < level ? below : above) = middle;
    }
    min_bits_[level] = above;
  }
  int level = 0;
  for (uint32_t run = 0; run < first_.size(); ++run) {
    while (level + 1 < kLevels && run << kShift >= min_bits_[level + 1]) ++level;
    first_[run] = static_cast<uint8_t>(level);
  }
}

}  // namespace kinome::viewer

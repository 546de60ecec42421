#pragma once

// Loads of bytes per lane.

#include <cstring>

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Loads bytes p[i] ... p[i + 3] in each lane, the first one lowest. All four must be readable, and
/// indices must not be negative.
inline Uint gather_bytes(const uint8_t* p, Int i) {
  alignas(kColumnAlignment) int32_t index[kLanes];
  alignas(kColumnAlignment) uint32_t value[kLanes];
  i.store(index);
  for (size_t lane = 0; lane < kLanes; ++lane) std::memcpy(value + lane, p + index[lane], 4);
  return Uint::load(value);
}
inline namespace formulas {
inline uint32_t gather_bytes(const uint8_t* p, std::same_as<int32_t> auto i) {
  uint32_t value;
  std::memcpy(&value, p + i, 4);
  return value;
}
}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide

#pragma once

// Bytes at each lane's place.

#include <cstring>

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// The bytes p[i] ... p[i + 3] of each lane, all of which must be readable, the first one lowest;
/// indices are not negative.
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

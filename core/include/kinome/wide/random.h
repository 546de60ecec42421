#pragma once

// Conversion of random bits to numbers.

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// kinome::to_unit_float() in each lane: in [0, 1).
KINOME_WIDE Float to_unit_float(Uint bits) {
  return to_float(as_int(shift_right<8>(bits))) * 0x1p-24f;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide

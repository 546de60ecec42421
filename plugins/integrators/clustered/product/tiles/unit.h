#pragma once

#include <cstddef>
#include <cstdint>

#include "kinome/color.h"

namespace kinome {

/// Sums of the light that a unit's primaries reflect: a single sum, or one per primary if film
/// positions matter because the filter weighs them differently. If light is divided by light group,
/// each of them is a row of sums, one per group.
struct UnitSums {
  Rgb* first = nullptr;  ///< nullptr: no estimate is requested
  bool is_split = false;
  uint32_t first_primary = 0;
  uint32_t groups = 1;  ///< length of a row

  Rgb& of(uint32_t primary) const {
    return is_split ? first[(primary - first_primary) * size_t{groups}] : *first;
  }
  /// Returns the sums of a light group.
  UnitSums of_group(uint32_t group) const {
    return {first ? first + group : nullptr, is_split, first_primary, groups};
  }
  explicit operator bool() const { return first != nullptr; }
};

/// The points of a pixel or of a tile, which share one comb of rays.
struct Unit {
  uint32_t first = 0;  ///< primaries are [first, end)
  uint32_t end = 0;
  uint32_t rays = 0;
  float candidates = 0;  ///< number of unshadowed glossy directions of all groups together
  uint64_t seed = 0;
};

}  // namespace kinome

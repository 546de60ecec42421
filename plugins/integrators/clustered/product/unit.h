#pragma once

#include <cstdint>

namespace kinome {

/// What shares one comb of rays: the points of a pixel, or of a tile.
struct Unit {
  uint32_t first = 0;  ///< its primaries, [first, end)
  uint32_t end = 0;
  uint32_t rays = 0;
  float candidates = 0;  ///< unshadowed glossy directions of all groups together
  uint64_t seed = 0;
};

}  // namespace kinome

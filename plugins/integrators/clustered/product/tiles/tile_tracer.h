#pragma once

#include <cstdint>
#include <vector>

#include "clustered/product/tiles/primaries.h"
#include "clustered/product/tiles/tile_grid.h"

namespace kinome {

/// Traces the primaries of a block, several tiles at a time. Reuses its memory; one object per
/// thread.
class TileTracer {
 public:
  explicit TileTracer(const Primaries::View& view) : primaries_(view) {}

  /// Traces count_of(x, y) primaries of each pixel of the wanted tiles of a block, and calls
  /// fn(tile, its primaries) for each tile. Adds the time of tracing to `seconds`.
  template <class Wanted, class Counts, class Function>
  void trace(const TileGrid& grid, int block, uint64_t seed, double& seconds,
             RenderCounters& counters, const Wanted& is_wanted, const Counts& count_of,
             const Function& fn) {
    const auto shade_waiting = [&] {
      {
        const StageTimer timer(seconds);
        primaries_.trace(seed, counters);
      }
      for (size_t k = 0; k < waiting_.size(); ++k) {
        TilePrimaries primaries = primaries_.tile(k);
        fn(waiting_[k], primaries);
      }
      waiting_.clear();
      primaries_.clear();
    };
    grid.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      if (!is_wanted(tile)) return;
      counts_.clear();
      tile.for_each_pixel([&](int x, int y) { counts_.push_back(count_of(x, y)); });
      if (!primaries_.add(tile.pixels, counts_)) {
        shade_waiting();
        primaries_.add(tile.pixels, counts_);
      }
      waiting_.push_back(tile);
    });
    shade_waiting();
  }

 private:
  Primaries primaries_;
  std::vector<TileGrid::Tile> waiting_;  ///< tiles whose primaries are not yet traced
  std::vector<uint16_t> counts_;
};

}  // namespace kinome

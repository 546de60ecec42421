#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "clustered/product/tiles/primaries.h"
#include "kinome/film.h"
#include "kinome/scheduler.h"
#include "kinome/shared_items.h"
#include "transport/blocks/blocks_of_tile.h"

namespace kinome {

/// Division of an image into blocks, and of these into tiles. A block is the unit of work of a
/// thread. The points of a tile, which has kTileSide x kTileSide pixels, share patches.
class TileGrid {
 public:
  static constexpr int kMaxTilesAcross = kTileSize / kTileSide;
  static constexpr int kMaxTilesOfBlock = kMaxTilesAcross * kMaxTilesAcross;

  struct Tile {
    int index;
    int place;  ///< index within the block
    Rect pixels;

    /// Calls fn(x, y) for each pixel, row by row.
    template <class Function>
    void for_each_pixel(const Function& fn) const {
      for (int y = pixels.y0; y < pixels.y1; ++y) {
        for (int x = pixels.x0; x < pixels.x1; ++x) fn(x, y);
      }
    }
  };
  using IsWanted = std::function<bool(const Tile&)>;
  /// Range of rows of blocks: [first, end).
  struct Rows {
    int first = 0;
    int end = 0;
  };

  explicit TileGrid(const Rect& crop) : crop_(crop), block_side_(tile_size(crop)) {}

  const Rect& crop() const { return crop_; }
  int block_side() const { return block_side_; }
  int tiles_across() const { return block_side_ / kTileSide; }  ///< tiles per row of a block
  int tiles_x() const { return (crop_.width() + kTileSide - 1) / kTileSide; }
  int tiles_y() const { return (crop_.height() + kTileSide - 1) / kTileSide; }
  int tiles() const { return tiles_x() * tiles_y(); }
  int blocks_x() const { return (crop_.width() + block_side_ - 1) / block_side_; }
  int blocks_y() const { return (crop_.height() + block_side_ - 1) / block_side_; }
  Rows all_rows() const { return {0, blocks_y()}; }

  Rect block(int index) const {
    const int left = crop_.x0 + index % blocks_x() * block_side_;
    const int top = crop_.y0 + index / blocks_x() * block_side_;
    return {left, top, std::min(left + block_side_, crop_.x1), std::min(top + block_side_, crop_.y1)};
  }
  /// Index of the block that contains a tile.
  int block_of(int tile) const {
    const int x = tile % tiles_x() / tiles_across(), y = tile / tiles_x() / tiles_across();
    return y * blocks_x() + x;
  }
  /// Index of a pixel in the crop window, row by row.
  size_t pixel(int x, int y) const {
    return static_cast<size_t>(y - crop_.y0) * crop_.width() + (x - crop_.x0);
  }

  /// Calls fn(tile) for each tile of a block.
  template <class Function>
  void for_each_tile(int block, const Function& fn) const {
    const int across = tiles_across();
    const int x0 = block % blocks_x() * across, y0 = block / blocks_x() * across;
    for (int i = 0; i < across * across; ++i) {
      const int x = x0 + i % across, y = y0 + i / across;
      if (x >= tiles_x() || y >= tiles_y()) continue;
      fn(Tile{y * tiles_x() + x,
              i,
              {crop_.x0 + x * kTileSide, crop_.y0 + y * kTileSide,
               std::min(crop_.x0 + (x + 1) * kTileSide, crop_.x1),
               std::min(crop_.y0 + (y + 1) * kTileSide, crop_.y1)}});
    }
  }

  /// Calls fn(block, worker, counters) for each block of these rows, on many threads. `make`
  /// creates a worker for each thread. The time is added to `stage`. `shared` transfers the blocks;
  /// its items are counted from the first block of the rows.
  template <class Worker, class Make, class Function>
  void for_each_block(Scheduler& scheduler, Rows rows, const char* stage, const Make& make,
                      const Function& fn, SharedItems* shared = nullptr) const {
    const size_t first = static_cast<size_t>(blocks_x()) * rows.first;
    const size_t blocks = static_cast<size_t>(blocks_x()) * (rows.end - rows.first);
    transport::Workers<Worker> workers;
    scheduler.for_each(
        blocks,
        [&](size_t item, RenderCounters& counters) {
          workers.with_one(make, [&](Worker& worker) {
            const StageTimer timer(counters.stage_seconds[stage]);
            fn(static_cast<int>(first + item), worker, counters);
          });
        },
        shared);
  }
  int first_block(Rows rows) const { return blocks_x() * rows.first; }

 private:
  Rect crop_;
  int block_side_;
};

}  // namespace kinome

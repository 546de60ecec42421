#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "clustered/product/product_renderer.h"

namespace kinome {

struct ProductRenderer::Workspace {
  Primaries primaries;
  std::vector<Tile> waiting;  ///< for their primaries
  std::vector<Patch> patches;
  std::vector<Visibility> visibility;
  std::vector<Visibility> unknown;
  std::vector<PointPlan> point_plans;
  std::vector<std::vector<VisibilityRecord>> records[kTilesAcross * kTilesAcross];
  std::vector<uint16_t> counts;
  std::vector<Rgb> sums;      ///< of a block's pixels, tile by tile
  std::vector<float> alphas;  ///< of the same
  std::vector<Vec3> diagnostics;
  std::vector<float> visibilities;     ///< of the patches of a tile
  std::vector<uint8_t> learned;        ///< TileMemory::learned of a patch, where it isn't kept
  RenderCounters* counters = nullptr;  ///< of the thread that works on the block
  std::vector<float> controls;
  VisibilityLearner learner;
  DiffuseStrata planner;
  Estimator estimator;
  Workspace(const Primaries::View& view, const CellLight& light, size_t padded,
            const CellNeighbours& neighbours)
      : primaries(view), learner(padded, &neighbours), planner(light), estimator(light) {}
  void reserve_visibility(size_t count, size_t padded) {
    while (visibility.size() < count) {
      visibility.emplace_back().resize(padded);
      visibility.back().reset();
    }
  }
};

template <class Function>
void ProductRenderer::for_each_block(Rows rows, const CellLight& light, const char* stage,
                                     const Function& fn) {
  const size_t first = static_cast<size_t>(blocks_x()) * rows.first;
  const size_t blocks = static_cast<size_t>(blocks_x()) * (rows.end - rows.first);
  std::vector<std::unique_ptr<Workspace>> workspaces;
  std::mutex mutex;
  context_.for_each(blocks, [&](size_t item, RenderCounters& counters) {
    std::unique_ptr<Workspace> work;
    {
      const std::lock_guard lock(mutex);
      if (!workspaces.empty()) {
        work = std::move(workspaces.back());
        workspaces.pop_back();
      }
    }
    if (!work) work = std::make_unique<Workspace>(view(), light, padded_cells(), neighbours_);
    work->counters = &counters;
    {
      const StageTimer timer(counters.stage_seconds[stage]);
      fn(static_cast<int>(first + item), *work);
    }
    const std::lock_guard lock(mutex);
    workspaces.push_back(std::move(work));
  });
}

template <class Function>
void ProductRenderer::for_each_tile(int block, const Function& fn) const {
  const int x0 = block % blocks_x() * kTilesAcross, y0 = block / blocks_x() * kTilesAcross;
  for (int i = 0; i < kTilesAcross * kTilesAcross; ++i) {
    const int x = x0 + i % kTilesAcross, y = y0 + i / kTilesAcross;
    if (x >= tiles_x() || y >= tiles_y()) continue;
    fn(Tile{y * tiles_x() + x, i,
            {crop_.x0 + x * kTile, crop_.y0 + y * kTile,
             std::min(crop_.x0 + (x + 1) * kTile, crop_.x1),
             std::min(crop_.y0 + (y + 1) * kTile, crop_.y1)}});
  }
}

template <class Counts, class Function>
void ProductRenderer::trace_tiles(int block, uint64_t seed, double& seconds, Workspace& work,
                                  const Counts& count_of, const Function& fn) const {
  std::vector<Tile>& waiting = work.waiting;
  const auto shade_waiting = [&] {
    {
      const StageTimer timer(seconds);
      work.primaries.trace(seed, *work.counters);
    }
    for (size_t k = 0; k < waiting.size(); ++k) {
      TilePrimaries primaries = work.primaries.tile(k);
      fn(waiting[k], primaries);
    }
    waiting.clear();
    work.primaries.clear();
  };
  for_each_tile(block, [&](const Tile& tile) {
    work.counts.clear();
    for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
      for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) work.counts.push_back(count_of(x, y));
    }
    if (!work.primaries.add(tile.pixels, work.counts)) {
      shade_waiting();
      work.primaries.add(tile.pixels, work.counts);
    }
    waiting.push_back(tile);
  });
  shade_waiting();
}

}  // namespace kinome

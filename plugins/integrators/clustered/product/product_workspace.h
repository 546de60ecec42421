#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "clustered/product/product_renderer.h"

namespace kinome {

struct ProductRenderer::Workspace {
  TilePrimaries primaries;
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
  Workspace(const CellLight& light, size_t padded, const CellNeighbours& neighbours)
      : learner(padded, &neighbours), planner(light), estimator(light) {}
  void reserve_visibility(size_t count, size_t padded) {
    while (visibility.size() < count) {
      visibility.emplace_back().resize(padded);
      visibility.back().reset();
    }
  }
};

template <class Function, class End>
void ProductRenderer::for_each_tile(Rows rows, const CellLight& light, const char* stage,
                                    const Function& fn, const End& end) {
  const size_t first = static_cast<size_t>(blocks_x()) * rows.first;
  const size_t blocks = static_cast<size_t>(blocks_x()) * (rows.end - rows.first);
  std::vector<std::unique_ptr<Workspace>> workspaces;
  std::mutex mutex;
  context_.for_each(blocks, [&](size_t item, RenderCounters& counters) {
    const size_t block = first + item;
    std::unique_ptr<Workspace> work;
    {
      const std::lock_guard lock(mutex);
      if (!workspaces.empty()) {
        work = std::move(workspaces.back());
        workspaces.pop_back();
      }
    }
    if (!work) work = std::make_unique<Workspace>(light, padded_cells(), neighbours_);
    work->counters = &counters;
    {
      const StageTimer timer(counters.stage_seconds[stage]);
      const int x0 = static_cast<int>(block) % blocks_x() * kTilesAcross;
      const int y0 = static_cast<int>(block) / blocks_x() * kTilesAcross;
      for (int i = 0; i < kTilesAcross * kTilesAcross; ++i) {
        const int x = x0 + i % kTilesAcross, y = y0 + i / kTilesAcross;
        if (x >= tiles_x() || y >= tiles_y()) continue;
        const Rect pixels{crop_.x0 + x * kTile, crop_.y0 + y * kTile,
                          std::min(crop_.x0 + (x + 1) * kTile, crop_.x1),
                          std::min(crop_.y0 + (y + 1) * kTile, crop_.y1)};
        fn(y * tiles_x() + x, i, pixels, *work, counters);
      }
      end(static_cast<int>(block), *work);
    }
    const std::lock_guard lock(mutex);
    workspaces.push_back(std::move(work));
  });
}

}  // namespace kinome

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "kinome/math.h"

namespace kinome {

class DistantCells;

/// Cells of distant light, kBlockLanes at a time as kernels take them, each block within a cone.
/// Cells of a block are neighbours, so that about half of all blocks are wholly below a surface's
/// horizon, and need not be looked at. Immutable; thread-safe.
class CellBlocks {
 public:
  CellBlocks() = default;
  explicit CellBlocks(const DistantCells& cells);

  size_t size() const { return size_; }
  /// Sets `blocks` to the numbers of those that may reach above the horizon of a unit normal (world
  /// space) within a cone of half angle asin(sine) around `normal`, going up. sine > 1: all.
  void find_facing(const Vec3& normal, float sine, std::vector<uint32_t>& blocks) const;

 private:
  size_t size_ = 0;
  Column<float> axis_[3];        ///< of each block's cone
  Column<float> cosine_, sine_;  ///< of its half angle; -1, 0 where that is a right one or more
};

}  // namespace kinome

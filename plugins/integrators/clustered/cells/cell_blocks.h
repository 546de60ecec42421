#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "kinome/math.h"

namespace kinome {

class DistantCells;

/// Cells of distant light in blocks of kBlockLanes, as kernels process them. Each block has a cone
/// that contains it. Cells of a block are neighbours, so that about half of all blocks are wholly
/// below a surface's horizon and can be skipped. Immutable; thread-safe.
class CellBlocks {
 public:
  CellBlocks() = default;
  explicit CellBlocks(const DistantCells& cells);

  size_t size() const { return size_; }
  /// Sets `blocks` to the indices, in ascending order, of the blocks that may reach above the
  /// horizon of a normal within a cone around `normal` (unit, world space) of half angle
  /// asin(sine). If sine > 1, these are all blocks.
  void find_facing(const Vec3& normal, float sine, std::vector<uint32_t>& blocks) const;

 private:
  size_t size_ = 0;
  Column<float> axis_[3];        ///< axis of each block's cone
  Column<float> cosine_, sine_;  ///< of its half angle; -1 and 0 from a right angle on
};

}  // namespace kinome

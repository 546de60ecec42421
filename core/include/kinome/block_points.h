#pragma once

#include "kinome/blocks.h"
#include "kinome/export.h"
#include "kinome/interaction.h"

namespace kinome {

/// Returns the interaction at point i of a block. Its t is not set.
KINOME_EXPORT SurfaceInteraction interaction_of(const SurfaceBlock& points, size_t i);

/// Sets point i of a block, except its ray and shape.
KINOME_EXPORT void set_point(const SurfaceBlock& points, size_t i, const SurfaceInteraction& si);

/// Block with a single point.
class KINOME_EXPORT PointBlock {
 public:
  explicit PointBlock(const SurfaceInteraction& si);
  PointBlock(const PointBlock&) = delete;
  PointBlock& operator=(const PointBlock&) = delete;
  const SurfaceBlock& block() const { return block_; }

 private:
  alignas(kColumnAlignment) float columns_[27][kBlockLanes] = {};
  alignas(kColumnAlignment) uint32_t indices_[2][kBlockLanes] = {};
  const Shape* shapes_[kBlockLanes] = {};
  SurfaceBlock block_;
};

}  // namespace kinome

#include "transport/media/bodies/majorant_grid.h"

#include <algorithm>
#include <cmath>

namespace kinome::transport {

namespace {

/// Number of voxels along each axis of a block, unless there would be more than kMaxBlocks. Smaller
/// blocks have tighter bounds, and take more steps.
constexpr uint32_t kVoxelsPerBlock = 8;
constexpr uint32_t kMaxBlocks = 64;

}  // namespace

MajorantGrid::MajorantGrid(const Medium& medium)
    : blocks_{medium.box(), glm::uvec3(1)},
      is_bounded_(is_finite(medium.box().lo) && is_finite(medium.box().hi)) {
  if (is_bounded_) {
    const glm::uvec3 voxels = medium.resolution();
    for (int a = 0; a < 3; ++a) {
      const uint32_t blocks = (voxels[a] + kVoxelsPerBlock - 1) / kVoxelsPerBlock;
      blocks_.size[a] = std::clamp(blocks, 1u, kMaxBlocks);
    }
    density_ = Vec3(blocks_.size) / blocks_.box.extent();
  }
  lo_.resize(blocks_.count());
  hi_.resize(blocks_.count());
  medium.extremes(blocks_, lo_.data(), hi_.data());
}

BlockWalk::BlockWalk(const MajorantGrid& grid, const Vec3& o, const Vec3& d, float length,
                     uint64_t random)
    : o_(o), d_(d), end_(length), random_(random) {
  if (grid.is_bounded()) enter(grid);
}

/// Moves to the part of the ray in the box.
void BlockWalk::enter(const MajorantGrid& grid) {
  for (int a = 0; a < 3; ++a) {
    const float inverse = 1 / d_[a];
    const float t0 = (grid.box().lo[a] - o_[a]) * inverse,
                t1 = (grid.box().hi[a] - o_[a]) * inverse;
    if (d_[a] == 0) {
      if (o_[a] < grid.box().lo[a] || o_[a] > grid.box().hi[a]) end_ = -1;
      continue;
    }
    t_ = std::max(t_, std::min(t0, t1));
    end_ = std::min(end_, std::max(t0, t1));
  }
  if (!(t_ < end_)) return;
  const Vec3 from = (p() - grid.box().lo) * grid.density();
  for (int a = 0; a < 3; ++a) {
    const int last = static_cast<int>(grid.size()[a]) - 1;
    at_[a] = std::clamp(static_cast<int>(from[a]), 0, last);
    step_[a] = d_[a] < 0 ? -1 : 1;
    if (d_[a] == 0) continue;
    const float speed = std::abs(d_[a]) * grid.density()[a];  // blocks per unit of length
    const auto face = static_cast<float>(at_[a] + (d_[a] < 0 ? 0 : 1));
    per_block_[a] = 1 / speed;
    next_[a] = t_ + std::max((face - from[a]) * static_cast<float>(step_[a]), 0.f) / speed;
  }
}

}  // namespace kinome::transport

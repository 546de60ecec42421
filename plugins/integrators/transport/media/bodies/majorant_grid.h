#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "kinome/medium.h"
#include "kinome/sampler.h"

namespace kinome::transport {

/// Bounds on the extinction of a medium in blocks of voxels. Immutable.
class MajorantGrid {
 public:
  explicit MajorantGrid(const Medium& medium);

  const Aabb& box() const { return blocks_.box; }
  /// False if the medium has no box. There is a single block then.
  bool is_bounded() const { return is_bounded_; }
  const glm::uvec3& size() const { return blocks_.size; }
  /// Blocks per unit of length along each axis.
  const kinome::Vec3& density() const { return density_; }
  float lo(size_t block) const { return lo_[block]; }
  float hi(size_t block) const { return hi_[block]; }

 private:
  BlockGrid blocks_;
  bool is_bounded_;
  kinome::Vec3 density_{0.f};
  std::vector<float> lo_, hi_;
};

/// Walk along a ray through the blocks of a grid, from event to event of a Poisson process whose
/// rate depends on the block. It also contains the ray's random number generator.
class BlockWalk {
 public:
  /// `length` may be infinite only if the grid is bounded. `random` is the seed of the generator.
  BlockWalk(const MajorantGrid& grid, const kinome::Vec3& o, const kinome::Vec3& d, float length,
            uint64_t random);

  /// Advances to the next event; `left` is its optical depth. `rate(lo, hi)` returns the rate of
  /// events in a block. `passes(lo, hi, length)` is called for each part of a block on the way. If
  /// the ray ends before the event, returns false and sets `left` to the remaining optical depth.
  template <class Rate, class Passes>
  bool advance(const MajorantGrid& grid, float& left, const Rate& rate, const Passes& passes);

  float t() const { return t_; }
  kinome::Vec3 p() const { return o_ + d_ * t_; }
  const kinome::Vec3& d() const { return d_; }
  /// Returns a random number in [0, 1).
  float random() {
    random_ += 0x9e3779b97f4a7c15u;
    return to_unit_float(static_cast<uint32_t>(mix_bits(random_) >> 32));
  }
  /// Returns an exponentially distributed random number.
  float optical_depth() { return -std::log(1 - random()); }

 private:
  void enter(const MajorantGrid& grid);
  kinome::Vec3 o_, d_;
  float t_ = 0, end_;
  glm::ivec3 at_{0};      ///< block
  glm::ivec3 step_{0};    ///< 1 or -1 along each axis
  kinome::Vec3 next_{kInfinity};  ///< distance of the next face along each axis
  kinome::Vec3 per_block_{0.f};   ///< distance between two faces
  uint64_t random_;
};

template <class Rate, class Passes>
bool BlockWalk::advance(const MajorantGrid& grid, float& left, const Rate& rate,
                        const Passes& passes) {
  const glm::ivec3 size(grid.size());
  while (t_ < end_) {
    const auto block = static_cast<size_t>((at_.z * size.y + at_.y) * size.x + at_.x);
    const float lo = grid.lo(block), hi = grid.hi(block);
    const int axis = next_.x < next_.y ? (next_.x < next_.z ? 0 : 2) : (next_.y < next_.z ? 1 : 2);
    const float face = std::min(next_[axis], end_);
    const float events = rate(lo, hi);
    const float length = std::max(face - t_, 0.f);
    if (events > 0 && left < events * length) {
      const float part = std::min(left / events, length);
      passes(lo, hi, part);
      t_ += part;
      left = 0;
      return true;
    }
    left -= events > 0 ? events * length : 0;
    passes(lo, hi, length);
    t_ = face;
    if (!(next_[axis] < end_)) break;
    at_[axis] += step_[axis];
    if (at_[axis] < 0 || at_[axis] >= size[axis]) break;
    next_[axis] += per_block_[axis];
  }
  t_ = end_;
  return false;
}

}  // namespace kinome::transport

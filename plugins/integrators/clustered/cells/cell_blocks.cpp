#include "clustered/cells/cell_blocks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "clustered/cells/light_cells.h"
#include "kinome/wide/lanes.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

/// Rounding errors of the cones [rad], and of their cosines.
constexpr float kRoundingAngle = 2e-3f, kRounding = 1e-5f;

}  // namespace

CellBlocks::CellBlocks(const DistantCells& cells) : size_(cells.padded_size() / kBlockLanes) {
  for (auto* const column : {&axis_[0], &axis_[1], &axis_[2], &cosine_, &sine_}) {
    column->assign(padded(size_), 0.f);
  }
  const auto axis_of = [&](size_t cell) {
    return Vec3(cells.axis()[0][cell], cells.axis()[1][cell], cells.axis()[2][cell]);
  };
  for (size_t block = 0; block < size_; ++block) {
    const size_t first = block * kBlockLanes;
    const size_t end = std::min<size_t>(first + kBlockLanes, cells.size());
    Vec3 sum(0.f);
    for (size_t c = first; c < end; ++c) sum += axis_of(c);
    const float length = glm::length(sum);
    const Vec3 axis = length > 0 ? sum / length : axis_of(first);
    float angle = 0;
    for (size_t c = first; c < end; ++c) {
      const float to_cell = std::acos(std::clamp(glm::dot(axis, axis_of(c)), -1.f, 1.f));
      angle = std::max(angle, to_cell + cells.radius()[c] + kRoundingAngle);
    }
    for (int i = 0; i < 3; ++i) axis_[i][block] = axis[i];
    const bool is_narrow = angle < std::numbers::pi_v<float> / 2;
    cosine_[block] = is_narrow ? std::cos(angle) : -1;
    sine_[block] = is_narrow ? std::sin(angle) : 0;
  }
}

/// A block is below if the angle between the normal and the block's axis is at least a right angle
/// plus both half angles. The sum of the half angles is less than a right angle if its cosine is
/// positive.
void CellBlocks::find_facing(const Vec3& normal, float sine, std::vector<uint32_t>& blocks) const {
  using namespace wide;
  blocks.resize(padded(size_) + kBlockLanes);
  const float cosine = kinome::safe_sqrt(1 - sine * sine);
  const wide::Vec3 n(normal);
  size_t count = 0;
  for_lanes(size_, [&](size_t i) {
    const wide::Vec3 axis(Float::load(&axis_[0][i]), Float::load(&axis_[1][i]),
                          Float::load(&axis_[2][i]));
    const Float c = Float::load(&cosine_[i]), s = Float::load(&sine_[i]);
    const Float cosine_of_both = cosine * c - sine * s, sine_of_both = sine * c + cosine * s;
    const Mask is_below = cosine_of_both > 0.f && dot(n, axis) < -sine_of_both - kRounding;
    const Uint number = as_uint(iota() + static_cast<int32_t>(i));
    count += store_selected(first_lanes(size_ - i) && !is_below, number, &blocks[count]);
  });
  blocks.resize(count);
}

}  // namespace kinome

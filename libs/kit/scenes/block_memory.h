#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/math.h"

/// Memory for block functions, with poisoned padding.
namespace kinome::check {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// Value after a column's padding, which functions must not overwrite.
inline constexpr float kGuard = 12345.678f;

/// Columns of `count` values. All values are NaN, including the padding.
class BlockMemory {
 public:
  explicit BlockMemory(size_t count) : length_(padded(count)) {}
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;

  float* one() {
    columns_.push_back(std::make_unique<Lanes[]>(length_ / kBlockLanes + 1));
    float* const values = columns_.back()[0].values;
    std::fill(values, values + length_, kNan);
    std::fill(values + length_, values + length_ + kBlockLanes, kGuard);
    return values;
  }
  Columns2 two() { return {one(), one()}; }
  Columns3 three() { return {one(), one(), one()}; }
  /// Returns a column of zeros.
  uint32_t* indices() {
    auto* const values = reinterpret_cast<uint32_t*>(one());
    std::memset(values, 0, length_ * sizeof(uint32_t));
    return values;
  }
  /// Returns columns for all fields of `count` surface points, with these shapes.
  SurfaceBlock surface(size_t count, const Shape** shapes) {
    return {count,   three(), three(), three(), three(),   three(),   three(),
            three(), three(), two(),   one(),   indices(), indices(), shapes};
  }
  /// Returns true if a function wrote beyond a column's padding.
  bool is_overrun() const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const auto& column) {
      const Lanes& guard = column[length_ / kBlockLanes];
      return std::any_of(guard.values, guard.values + kBlockLanes,
                         [](float value) { return value != kGuard; });
    });
  }

 private:
  struct alignas(kColumnAlignment) Lanes {
    float values[kBlockLanes];
  };
  size_t length_;
  std::vector<std::unique_ptr<Lanes[]>> columns_;
};

}  // namespace kinome::check

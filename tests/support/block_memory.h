#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "kinome/columns.h"
#include "kinome/math.h"

/// Memory for tests of functions over blocks, whose padding is poisoned.
namespace kinome::test {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// What lies behind a column's padding, and must stay there.
inline constexpr float kGuard = 12345.678f;

/// Numbers of values: none, and some that end in, before and behind the end of vectors.
inline constexpr size_t kRanges[] = {0, 1, 15, 16, 17, 33};

/// Columns of `count` values: all NaN, their padding included.
class BlockMemory {
 public:
  explicit BlockMemory(size_t count) : length_(padded(count)) {}
  BlockMemory(const BlockMemory&) = delete;
  BlockMemory& operator=(const BlockMemory&) = delete;
  ~BlockMemory() {
    for (const auto& column : columns_) {
      for (size_t i = length_; i < length_ + kBlockLanes; ++i) {
        EXPECT_EQ(column[i / kBlockLanes].values[i % kBlockLanes], kGuard)
            << "written behind a column's padding";
      }
    }
  }

  float* one() {
    columns_.push_back(std::make_unique<Lanes[]>(length_ / kBlockLanes + 1));
    float* const values = columns_.back()[0].values;
    std::fill(values, values + length_, kNan);
    std::fill(values + length_, values + length_ + kBlockLanes, kGuard);
    return values;
  }
  Columns2 two() { return {one(), one()}; }
  Columns3 three() { return {one(), one(), one()}; }
  /// Zeros.
  uint32_t* indices() {
    auto* const values = reinterpret_cast<uint32_t*>(one());
    std::memset(values, 0, length_ * sizeof(uint32_t));
    return values;
  }

 private:
  struct alignas(kColumnAlignment) Lanes {
    float values[kBlockLanes];
  };
  size_t length_;
  std::vector<std::unique_ptr<Lanes[]>> columns_;
};

inline float largest_difference(const Vec3& a, const Vec3& b) {
  return max_component(glm::abs(a - b));
}
inline float largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}

}  // namespace kinome::test

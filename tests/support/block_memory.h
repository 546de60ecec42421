#pragma once

#include <gtest/gtest.h>

#include "kit/scenes/block_memory.h"

namespace kinome::test {

using check::kGuard;
using check::kNan;

/// Column lengths: empty, and just below, at and above a multiple of the vector width.
inline constexpr size_t kRanges[] = {0, 1, 15, 16, 17, 33};

/// Columns of `count` values. The destructor checks that the memory after the padding is intact.
class BlockMemory : public check::BlockMemory {
 public:
  using check::BlockMemory::BlockMemory;
  ~BlockMemory() { EXPECT_FALSE(is_overrun()) << "written past a column's padding"; }
};

inline float largest_difference(const Vec3& a, const Vec3& b) {
  return max_component(glm::abs(a - b));
}
inline float largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}

}  // namespace kinome::test

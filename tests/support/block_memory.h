#pragma once

#include <gtest/gtest.h>

#include "check/block_memory.h"

namespace kinome::test {

using check::kGuard;
using check::kNan;

/// Numbers of values: none, and some that end in, before and behind the end of vectors.
inline constexpr size_t kRanges[] = {0, 1, 15, 16, 17, 33};

/// Columns of `count` values, which are looked at in the end.
class BlockMemory : public check::BlockMemory {
 public:
  using check::BlockMemory::BlockMemory;
  ~BlockMemory() { EXPECT_FALSE(is_overrun()) << "written behind a column's padding"; }
};

inline float largest_difference(const Vec3& a, const Vec3& b) {
  return max_component(glm::abs(a - b));
}
inline float largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}

}  // namespace kinome::test

#pragma once

// As the library's kernels are compiled: for all that this machine may have, scalar code included.
#define HWY_COMPILE_ALL_ATTAINABLE
#include <hwy/highway.h>

#include <gtest/gtest.h>

#include "clustered/points/light_cut.h"

namespace kinome::test {

/// Calls fn() with the kernels of each instruction set that this machine has, one after the other:
/// use_scalar_kernels knows only the best and the plainest. Which one it is, is in failures' trace.
/// Not thread-safe.
template <class Function>
void for_each_instruction_set(const Function& fn) {
  use_scalar_kernels(false);
  // Asked before any is chosen, which would change the answer.
  const std::vector<int64_t> targets = hwy::SupportedAndGeneratedTargets();
  std::vector<std::string> names;
  for (const int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    names.push_back(simd_instruction_set());
    SCOPED_TRACE(names.back());
    fn();
  }
  use_scalar_kernels(false);
  // Otherwise nothing was chosen at all.
  for (size_t i = 1; i < names.size(); ++i) EXPECT_NE(names[i], names[i - 1]);
}

}  // namespace kinome::test

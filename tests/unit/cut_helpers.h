#pragma once

#include <gtest/gtest.h>

#include "instruction_sets.h"

namespace kinome::test {

/// Vector code sums in the order of scalar code: they differ by fused multiply-adds alone. These
/// change a dot product by some units of 2^-24, and an importance, where one cancels to a hundredth
/// of its terms, by a hundred times that: 1e-5. A probability is moreover the difference of two
/// running sums of at most 1, each rounded to half a unit, in both of them: 4 x 2^-25.
inline void expect_kernels_agree(const LightCut& cut, const LightCut::Point& point) {
  ClusterPmf scalar_pmf;
  use_scalar_kernels(true);
  EXPECT_TRUE(simd_instruction_set() == "SCALAR" || simd_instruction_set() == "EMU128");
  cut.build(Importance::kJoint, point, scalar_pmf);
  for_each_instruction_set([&] {
    ClusterPmf vector_pmf;
    cut.build(Importance::kJoint, point, vector_pmf);
    ASSERT_EQ(vector_pmf.empty(), scalar_pmf.empty());
    if (vector_pmf.empty()) return;
    for (uint32_t c = 0; c < cut.size(); ++c) {
      EXPECT_EQ(vector_pmf.hits(c), scalar_pmf.hits(c));
      EXPECT_NEAR(vector_pmf.probability(c), scalar_pmf.probability(c),
                  1e-5f * vector_pmf.probability(c) + 0x1p-23f);
    }
  });
}

}  // namespace kinome::test

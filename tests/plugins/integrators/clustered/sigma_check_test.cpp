// Tests the correction of sigma by the pilot's rays.
#include "clustered/product/tiles/sigma_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinome::test::sigma_check_test {
namespace {

constexpr size_t kCells = 16;

/// Returns the corrected sigma of cells that all have the same v and sigma.
float corrected(const SigmaCheck& check, float v, float sigma) {
  Visibility visibility(kCells);
  for (size_t c = 0; c < kCells; ++c) {
    visibility.v[c] = v;
    visibility.sigma[c] = sigma;
    visibility.sigma_mixed[c] = 1;
  }
  check.correct(visibility);
  for (size_t c = 0; c < kCells; ++c) {
    EXPECT_EQ(visibility.sigma[c], visibility.sigma[0]);
    EXPECT_EQ(visibility.v[c], v);
    EXPECT_EQ(visibility.sigma_mixed[c], 1);
  }
  return visibility.sigma[0];
}

TEST(SigmaCheck, LeavesClassesWithoutRecords) {
  SigmaCheck check;
  EXPECT_EQ(corrected(check, 0, 0.1f), 0.1f);
  check.finish();
  EXPECT_FLOAT_EQ(corrected(check, 0, 0.1f), 0.1f);
  EXPECT_FLOAT_EQ(corrected(check, 0.5f, 0.5f), 0.5f);
}

/// Class `hidden`: one ray in 400 finds light, but one in 25 was expected. Class `visible`: as
/// expected.
TEST(SigmaCheck, MatchesTheRecordsOfRays) {
  constexpr float kSigma = 0.2f;
  SigmaCheck check;
  for (int i = 0; i < 40000; ++i) {
    check.add_record(0, kSigma, i % 400 == 0);
    check.add_record(1, kSigma, i % 25 != 0);
    check.add_record(1, 0.02f, true);
  }
  EXPECT_EQ(corrected(check, 0, kSigma), kSigma);  // unchanged before finish()
  check.finish();
  EXPECT_NEAR(corrected(check, 0, kSigma), 0.05f, 0.001f);
  EXPECT_NEAR(corrected(check, 1, kSigma), kSigma, 0.001f);
  // For v = 1 and sigma .02, 16 hidden rays were expected and none found. The factor 2 / 18 of
  // sigma² is applied as its square root, because the cell seems visible.
  EXPECT_NEAR(corrected(check, 1, 0.02f), 0.02f * std::pow(2 / 18.f, 0.25f), 2e-4f);
  // Similar sigmas get similar corrections, and distant ones none.
  EXPECT_NEAR(corrected(check, 0, 0.9f * kSigma) / (0.9f * kSigma), 0.25f, 0.01f);
  EXPECT_FLOAT_EQ(corrected(check, 0, 0.02f), 0.02f);
  EXPECT_FLOAT_EQ(corrected(check, 0.5f, kSigma), kSigma);
  check.forget();
  EXPECT_EQ(corrected(check, 0, kSigma), kSigma);
}

TEST(SigmaCheck, AFewRaysChangeLittle) {
  SigmaCheck check;
  for (int i = 0; i < 10; ++i) check.add_record(0, 0.1f, false);
  check.finish();
  EXPECT_GT(corrected(check, 0, 0.1f), 0.097f);
  EXPECT_LT(corrected(check, 0, 0.1f), 0.1f);
}

/// Sigma has a minimum, because rays must be sent to all possible light.
TEST(SigmaCheck, SigmaHasAMinimum) {
  SigmaCheck check;
  for (int i = 0; i < 1000000; ++i) check.add_record(0, 0.1f, false);
  check.finish();
  EXPECT_NEAR(corrected(check, 0, 0.1f), 0.1f * std::sqrt(0.02f), 1e-4f);
  EXPECT_GE(corrected(check, 0, 1e-5f), 0.99e-3f);
}

}  // namespace
}  // namespace kinome::test::sigma_check_test

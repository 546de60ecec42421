// Tests the guide of light points: its mapping of random numbers, and its densities.
#include "clustered/product/lights/light_guide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "plugins/integrators/kernels/kernel_helpers.h"
#include "support/statistics.h"

namespace kinome::test::light_guide_test {
namespace {

constexpr double kAlpha = 1e-4;  // false-alarm rate of each statistical test
constexpr int kSources = 3;
const std::vector<float> kShares{0.5f, 0.3f, 0.2f};

/// Use of a draw. The second source shines through a slit, and the third is a little useful
/// everywhere. The first is useful only on one side, so the guide reduces its share.
float use_of(uint32_t source, const LightGuide::Numbers& at) {
  if (source == 0) return at[0] < 0.1f ? 1e-3f : 0.f;
  if (source == 1) return at[1] > 0.3f && at[1] < 0.34f && at[3] < 0.5f ? 1.f : 0.f;
  return source == 2 ? 0.01f : 0.f;
}

uint32_t pick_source(const std::vector<double>& ends, float u) {
  const auto after = std::upper_bound(ends.begin(), ends.end(), u * ends.back());
  return static_cast<uint32_t>(std::min<ptrdiff_t>(after - ends.begin(), kSources - 1));
}

std::vector<double> ends_of(const LightGuide& guide) {
  return guide.empty() ? std::vector<double>{0.5, 0.8, 1.} : guide.ends();
}

/// Learns in rounds; each round uses the draws of the previous guide.
LightGuide learn(int rounds, uint32_t draws) {
  LightGuide guide;
  Random random(1);
  for (int round = 0; round < rounds; ++round) {
    std::vector<LightGuide::Use> uses;
    for (uint32_t i = 0; i < draws; ++i) {
      const uint32_t s = pick_source(ends_of(guide), random.unit());
      LightGuide::Numbers at{random.unit(), random.unit(), random.unit(), random.unit()};
      const float density = guide.warp(s, at);
      uses.push_back({s, at, use_of(s, at) / density});
    }
    guide = LightGuide(kShares, uses, draws);
  }
  return guide;
}

TEST(LightGuide, LeavesNumbersUnchangedUntilItHasLearned) {
  const LightGuide none;
  LightGuide::Numbers at{0.1f, 0.2f, 0.3f, 0.4f};
  const LightGuide::Numbers before = at;
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.warp(0, at), 1.f);
  EXPECT_EQ(at, before);
  const std::vector<LightGuide::Use> useless(100, {0, before, 0.f});
  EXPECT_TRUE(LightGuide(kShares, useless, 100).empty());
  EXPECT_TRUE(LightGuide(kShares, {}, 100).empty());
}

/// The mean of 1 / density over the draws in any box is the box's volume, so that guided estimates
/// are unbiased.
TEST(LightGuide, ReturnsItsDensity) {
  constexpr int kParts = 25, kDraws = 1 << 20;
  const LightGuide guide = learn(3, 4000);
  Random random(2);
  std::vector<double> sums(kSources * kParts * 2), squares(sums.size());
  float min_density = kInfinity;
  for (int i = 0; i < kDraws; ++i) {
    const uint32_t s = pick_source(guide.ends(), random.unit());
    LightGuide::Numbers at{random.unit(), random.unit(), random.unit(), random.unit()};
    const float density = guide.warp(s, at);
    min_density = std::min(min_density, density);
    for (const float v : at) ASSERT_TRUE(v >= 0 && v < 1) << v;
    const size_t bin = (s * kParts + static_cast<int>(at[1] * kParts)) * 2 + (at[3] < 0.5f ? 0 : 1);
    sums[bin] += 1 / density;
    squares[bin] += 1 / sqr(static_cast<double>(density));
  }
  std::vector<Estimate> measured, volume;
  for (size_t bin = 0; bin < sums.size(); ++bin) {
    const double mean = sums[bin] / kDraws;
    measured.push_back({mean, (squares[bin] / kDraws - mean * mean) / kDraws});
    volume.push_back({double{kShares[bin / (kParts * 2)]} / (kParts * 2), 0});
  }
  const Verdict verdict = z_test(measured, volume, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
  // A quarter of the draws isn't guided.
  EXPECT_GE(min_density, 0.25f * (1 - 1e-5f));
}

TEST(LightGuide, LearnsUsefulLight) {
  double found[2];
  for (const int rounds : {0, 3}) {
    const LightGuide guide = learn(rounds, 4000);
    Random random(3);
    int useful = 0;
    for (int i = 0; i < 100000; ++i) {
      const uint32_t s = pick_source(ends_of(guide), random.unit());
      LightGuide::Numbers at{random.unit(), random.unit(), random.unit(), random.unit()};
      guide.warp(s, at);
      useful += s == 1 && use_of(s, at) > 0;
    }
    found[rounds > 0] = useful / 1e5;
  }
  EXPECT_NEAR(found[0], 0.3 * 0.04 * 0.5, 0.001);
  EXPECT_GT(found[1], 0.3);
}

TEST(LightGuide, KeepsTheEndsOfTheInterval) {
  const LightGuide guide = learn(3, 4000);
  for (const float u : {0.f, 0x1p-24f, 0x1.fffffep-1f}) {
    for (uint32_t s = 0; s < kSources; ++s) {
      LightGuide::Numbers at{u, u, u, u};
      EXPECT_GT(guide.warp(s, at), 0.f);
      for (const float v : at) EXPECT_TRUE(v >= 0 && v < 1) << v;
    }
  }
}

/// The scale of the use is arbitrary. A single draw with all the use is hardly any evidence.
TEST(LightGuide, IgnoresSingleDrawsAndTheScaleOfUses) {
  std::vector<LightGuide::Use> one(1000, {0, {0.5f, 0.5f, 0.5f, 0.5f}, 0.f});
  Random random(4);
  for (auto& use : one) {
    for (float& v : use.at) v = random.unit();
  }
  one[7].use = 1e30f;
  LightGuide guide(kShares, one, 1000);
  LightGuide::Numbers at = one[7].at;
  EXPECT_LE(guide.warp(0, at), 2.f);
  for (auto& use : one) use.use = 1e-30f;
  guide = LightGuide(kShares, one, 1000);
  at = {0.1f, 0.6f, 0.9f, 0.3f};
  // All of the use is the first source's, whose share without a guide is 0.5.
  EXPECT_NEAR(guide.warp(0, at), 0.75f * 2 + 0.25f, 0.1f);
  one[3].use = kInfinity;
  EXPECT_TRUE(LightGuide(kShares, one, 1000).empty());
}

}  // namespace
}  // namespace kinome::test::light_guide_test

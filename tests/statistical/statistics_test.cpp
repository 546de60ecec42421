#include "support/statistics.h"

#include <gtest/gtest.h>

#include <random>

#include "kinome/warp.h"

/// Tests of the statistical tests: correct samplers pass at the stated rate, and wrong ones fail.
namespace kinome::test::statistics_test {
namespace {

// Values for even degrees of freedom are exact, because the tail is a finite sum. Others are from
// tables.
TEST(Statistics, Chi2TailHasKnownValues) {
  EXPECT_NEAR(chi2_tail(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(chi2_tail(18.307038053275146, 10), 0.05, 1e-12);
  EXPECT_NEAR(chi2_tail(1000, 1000), 0.4940528538292414, 1e-11);
  EXPECT_NEAR(chi2_tail(1200, 1000) / 1.225594233062292e-05, 1, 1e-9);
  EXPECT_NEAR(chi2_tail(300, 200) / 5.924540335483919e-06, 1, 1e-9);
  EXPECT_EQ(chi2_tail(0, 5), 1);
  EXPECT_NEAR(chi2_tail(5, 100), 1, 1e-12);
  EXPECT_NEAR(normal_two_sided(3), 0.0026997960632601866, 1e-15);
  EXPECT_EQ(normal_two_sided(0), 1);
}

// The number of false alarms in 1000 runs at alpha = .05 is binomial: mean 50, deviation 6.9. The
// bounds are 4.5 deviations, which are exceeded once in 1e5.
constexpr int kRuns = 1000;
constexpr double kAlpha = 0.05;
constexpr int kMinAlarms = 19;
constexpr int kMaxAlarms = 81;

TEST(Statistics, Chi2AlarmsAtTheStatedRate) {
  std::mt19937 bits(1);
  const std::vector<double> weights{1, 2, 3, 4, 10, 30, 50, 0.01, 0.02, 0};
  std::discrete_distribution<int> draw(weights.begin(), weights.end());
  int alarms = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> observed(weights.size()), expected(weights.size());
    for (int i = 0; i < 2000; ++i) ++observed[draw(bits)];
    for (size_t i = 0; i < weights.size(); ++i) expected[i] = weights[i] * 2000 / 100.03;
    alarms += !chi2_test(observed, expected, kAlpha).passed;
  }
  EXPECT_GE(alarms, kMinAlarms);
  EXPECT_LE(alarms, kMaxAlarms);
}

TEST(Statistics, Chi2RefusesInvalidInput) {
  EXPECT_FALSE(chi2_test({1, 99}, {0, 100}, 1e-6).passed) << "a sample in a cell of zero density";
  EXPECT_FALSE(chi2_test({50, 50}, {49, 49}, 1e-6).passed) << "expectations with another sum";
  EXPECT_FALSE(chi2_test({50, 50}, {50}, 1e-6).passed);
  EXPECT_FALSE(chi2_test({50, 50}, {50, std::nan("")}, 1e-6).passed);
  EXPECT_TRUE(chi2_test({50, 50, 0}, {50, 50, 0}, 0.5).passed);
}

SphereChi2 cosine_test(int samples, uint64_t seed) {
  SphereChi2 test;
  test.sample = [](float, Vec2 u) { return square_to_cosine_hemisphere(u); };
  test.pdf = [](const Vec3& d) { return cosine_hemisphere_pdf(d.z); };
  test.samples = samples;
  test.seed = seed;
  return test;
}

TEST(Statistics, SphereChi2AlarmsAtTheStatedRate) {
  int alarms = 0;
  for (int run = 0; run < kRuns; ++run) {
    SphereChi2 test = cosine_test(2000, static_cast<uint64_t>(run) + 1);
    // About a third is rejected, to test both halves of the test.
    test.sample = [](float u1, Vec2 u) -> std::optional<Vec3> {
      if (u1 < 0.3f) return std::nullopt;
      return square_to_cosine_hemisphere(u);
    };
    test.pdf = [](const Vec3& d) { return 0.7f * cosine_hemisphere_pdf(d.z); };
    test.res_theta = 8;
    test.subdivide = 4;
    alarms += !sphere_chi2_test(test, kAlpha).passed;
  }
  EXPECT_GE(alarms, kMinAlarms);
  EXPECT_LE(alarms, kMaxAlarms);
}

TEST(Statistics, SphereChi2FindsDefectsOfOnePercent) {
  constexpr int kSamples = 300000;
  EXPECT_TRUE(sphere_chi2_test(cosine_test(kSamples, 3), 1e-3).passed);
  for (const float factor : {0.99f, 1.01f}) {
    SphereChi2 test = cosine_test(kSamples, 3);
    test.pdf = [factor](const Vec3& d) { return factor * cosine_hemisphere_pdf(d.z); };
    EXPECT_FALSE(sphere_chi2_test(test, 1e-6).passed) << "density times " << factor;
  }
  SphereChi2 lost = cosine_test(kSamples, 3);
  lost.sample = [](float u1, Vec2 u) -> std::optional<Vec3> {
    if (u1 < 0.01f) return std::nullopt;
    return square_to_cosine_hemisphere(u);
  };
  EXPECT_FALSE(sphere_chi2_test(lost, 1e-6).passed) << "1 % of the samples lost";
  SphereChi2 uniform = cosine_test(kSamples, 3);
  uniform.pdf = [](const Vec3& d) { return d.z > 0 ? kUniformHemispherePdf : 0.f; };
  EXPECT_FALSE(sphere_chi2_test(uniform, 1e-6).passed) << "a missing cosine";
  SphereChi2 below = cosine_test(kSamples, 3);
  below.sample = [](float u1, Vec2 u) {
    Vec3 d = square_to_cosine_hemisphere(u);
    if (u1 < 1e-5f) d.z = -d.z;
    return d;
  };
  EXPECT_FALSE(sphere_chi2_test(below, 1e-6).passed) << "few samples in cells of zero density";
}

// A peak much narrower than a cell, at the pole, where cells are widest in angle.
TEST(Statistics, SphereChi2IntegratesNarrowPeaks) {
  constexpr float kExponent = 20000;
  SphereChi2 test;
  test.sample = [](float, Vec2 u) { return square_to_cosine_power(u, kExponent); };
  test.pdf = [](const Vec3& d) {
    return d.z > 0 ? (kExponent + 1) / (2 * kPi) * std::pow(d.z, kExponent) : 0.f;
  };
  test.samples = 100000;
  const Verdict verdict = sphere_chi2_test(test, 1e-3);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

TEST(Statistics, JacobianTestDetectsOnePercent) {
  const auto sample = [](Vec2 u) { return std::optional<Vec3>(square_to_cosine_hemisphere(u)); };
  const auto verdict = [&](float factor) {
    return jacobian_test(
        sample, [factor](const Vec3& d) { return factor * cosine_hemisphere_pdf(d.z); }, 2000,
        1e-3);
  };
  EXPECT_TRUE(verdict(1.f).passed) << verdict(1.f).text;
  EXPECT_FALSE(verdict(1.01f).passed);
  EXPECT_FALSE(verdict(0.99f).passed);
}

TEST(Statistics, ZTestAlarmsAtTheStatedRateAndFindsBias) {
  std::mt19937 bits(7);
  std::normal_distribution<double> normal;
  int alarms = 0;
  int found = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Estimate> a(20), b(20), biased(20);
    for (size_t i = 0; i < a.size(); ++i) {
      a[i] = {5 + normal(bits), 1};
      b[i] = {5 + 0.5 * normal(bits), 0.25};
      biased[i] = {b[i].mean + 1.5, 0.25};
    }
    alarms += !z_test(a, b, kAlpha).passed;
    found += !z_test(a, biased, kAlpha).passed;
  }
  EXPECT_GE(alarms, kMinAlarms);
  EXPECT_LE(alarms, kMaxAlarms);
  // 1.5 on each of 20 is 6 deviations of the sum.
  EXPECT_GT(found, 0.99 * kRuns);
  EXPECT_TRUE(z_test({{1, 0}}, {{1, 0}}, 0.5).passed) << "equal exact values";
  EXPECT_FALSE(z_test({{1, 0}}, {{1.001, 0}}, 1e-6).passed) << "unequal exact values";
  EXPECT_FALSE(z_test({{std::nan(""), 1}}, {{1, 1}}, 1e-6).passed);
}

TEST(Statistics, LargestZTestHasNoMoreAlarmsForDependentPairs) {
  std::mt19937 bits(8);
  std::normal_distribution<double> normal;
  int alarms = 0, alarms_of_same = 0, found = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Estimate> independent(3);
    for (Estimate& e : independent) e = {5 + normal(bits), 1};
    // The channels of grey light.
    const std::vector<Estimate> same(3, {5 + normal(bits), 1}), expected(3, {5, 0});
    alarms += !largest_z_test(independent, expected, kAlpha).passed;
    alarms_of_same += !largest_z_test(same, expected, kAlpha).passed;
    found += !largest_z_test({{11 + normal(bits), 1}}, {{5, 0}}, kAlpha).passed;
  }
  EXPECT_GE(alarms, kMinAlarms);
  EXPECT_LE(alarms, kMaxAlarms);
  EXPECT_LE(alarms_of_same, kMaxAlarms);
  EXPECT_GT(found, 0.99 * kRuns);
}

}  // namespace
}  // namespace kinome::test::statistics_test

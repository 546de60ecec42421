#pragma once

#include <functional>
#include <optional>

#include "kinome/math.h"
#include "kit/statistics/statistics.h"

/// The statistics of `kinome check`, and tests of distributions and of bias that only the project's
/// own tests use.
namespace kinome::test {
using namespace check;

/// Compares the histogram of `samples` directions with the integral of `pdf` over each cell of the
/// sphere. There are res_theta rows of equal cos theta by 2 res_theta columns. sample() returns
/// nullopt if sampling fails; the density may then integrate to less than 1. `subdivide`: nodes per
/// cell and axis for the integral of the pdf.
struct SphereChi2 {
  std::function<std::optional<Vec3>(float u1, Vec2 u2)> sample;
  std::function<float(const Vec3&)> pdf;
  int samples = 1000000;
  int res_theta = 32;
  int subdivide = 16;
  uint64_t seed = 1;
};
Verdict sphere_chi2_test(const SphereChi2& test, double alpha);

/// Compares pdf(sample(u)) with 1 / |d direction / d u| by central differences, at `count` random
/// u. Points are skipped if the finite difference is unreliable, because it depends on the step; at
/// least half must remain. The median of the relative errors must be at most `tolerance`, and their
/// 95 % quantile at most 10 times that.
Verdict jacobian_test(const std::function<std::optional<Vec3>(Vec2)>& sample,
                      const std::function<float(const Vec3&)>& pdf, int count, double tolerance,
                      uint64_t seed = 1);

/// Power of z_test(): the relative bias of `a` against the sum of `b` that the test of the sum
/// detects with probability 0.9. Infinity if the sum is 0, and NaN if there is no noise either
/// (black images), so that no upper limit accepts it.
double detectable_bias(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                       double alpha);

}  // namespace kinome::test

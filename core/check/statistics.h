#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinome/export.h"
#include "kinome/math.h"

/// Statistical tests, of `kinome check` and of the project's own. Every one takes the false-alarm
/// rate `alpha` it is run at; seeds are fixed, so a passing test keeps passing until what it tests
/// changes.
namespace kinome::check {

struct Verdict {
  bool passed = false;
  double p_value = 0;
  std::string text;  ///< what was measured, for the failure message
};

/// P(X >= statistic) of a chi² distribution.
KINOME_EXPORT double chi2_tail(double statistic, double degrees_of_freedom);
/// P(|Z| >= |z|).
KINOME_EXPORT double normal_two_sided(double z);

/// Frequencies against expectations. Cells with an expectation below 5 are pooled; a sample in a
/// cell whose expectation is 0 fails at once.
KINOME_EXPORT Verdict chi2_test(const std::vector<double>& observed, const std::vector<double>& expected,
                  double alpha);

/// Draws `count` directions and compares their histogram over the sphere (res_theta rows of equal
/// cos theta by 2 res_theta columns) with the integral of `pdf` over each cell. sample() returns
/// nullopt for a sample that is rejected: the density may then integrate to less than 1.
/// `subdivide`: midpoints per cell and axis for the integral of the pdf.
struct SphereChi2 {
  std::function<std::optional<Vec3>(float u1, Vec2 u2)> sample;
  std::function<float(const Vec3&)> pdf;
  int samples = 1000000;
  int res_theta = 32;
  int subdivide = 16;
  uint64_t seed = 1;
};
KINOME_EXPORT Verdict sphere_chi2_test(const SphereChi2& test, double alpha);

/// pdf(sample(u)) against 1 / |d direction / d u| by central differences, at `count` random u.
/// Points where the finite difference itself is unreliable (it changes with the step) are skipped;
/// at least half must remain. `tolerance` is relative and bounds the median; 10x it the 95 % point.
KINOME_EXPORT Verdict jacobian_test(const std::function<std::optional<Vec3>(Vec2)>& sample,
                      const std::function<float(const Vec3&)>& pdf, int count, double tolerance,
                      uint64_t seed = 1);

/// Mean and variance of the mean, one pass.
class Moments {
 public:
  void add(double x) {
    ++n_;
    const double d = x - mean_;
    mean_ += d / static_cast<double>(n_);
    m2_ += d * (x - mean_);
  }
  uint64_t count() const { return n_; }
  double mean() const { return mean_; }
  double variance_of_mean() const {
    return n_ < 2 ? 0 : m2_ / static_cast<double>(n_ - 1) / static_cast<double>(n_);
  }

 private:
  uint64_t n_ = 0;
  double mean_ = 0;
  double m2_ = 0;
};

/// Welch z-test of many pairs of means at family-wise rate alpha (Šidák), plus a signed z-test of
/// the sum, for which the pairs must be independent. An exact value has variance 0.
struct Estimate {
  double mean = 0;
  double variance_of_mean = 0;
};
KINOME_EXPORT Verdict z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b, double alpha);

/// The same without the sum: pairs may depend on one another, as the channels of a colour do, and
/// sums may be among them.
KINOME_EXPORT Verdict largest_z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                                     double alpha);

/// The power of that test: by what share of the sum of `b` all of `a` may be off and is found 9
/// times of 10, by the sum's z alone. Infinite where the sum is 0, and not a number where there is
/// no noise either (pictures that are all black): no upper limit accepts that.
KINOME_EXPORT double detectable_bias(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                       double alpha);

}  // namespace kinome::check

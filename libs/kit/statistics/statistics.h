#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "kinome/export.h"
#include "kinome/math.h"

/// Statistical tests, used by `kinome check` and by the project's own tests. Each one takes the
/// false-alarm rate `alpha`. Seeds are fixed, so a passing test keeps passing until the tested code
/// changes.
namespace kinome::check {

struct Verdict {
  bool passed = false;
  double p_value = 0;
  std::string text;  ///< measured values, for the failure message
};

inline Verdict fail(std::string text) {
  return {false, 0, std::move(text)};
}
/// Returns the p-value of two tests together, such that their joint false-alarm rate is alpha.
inline double bonferroni(double p, double q) {
  return std::min(1., 2 * std::min(p, q));
}

/// Returns P(X >= statistic) for a chi² distribution.
KINOME_EXPORT double chi2_tail(double statistic, int degrees_of_freedom);
/// Returns P(|Z| >= |z|) for the standard normal distribution.
KINOME_EXPORT double normal_two_sided(double z);

/// Compares frequencies with their expectations. Cells with an expectation below 5 are pooled. The
/// test fails if there is a sample in a cell with expectation 0.
KINOME_EXPORT Verdict chi2_test(const std::vector<double>& observed, const std::vector<double>& expected,
                  double alpha);

/// Mean of values and its variance, computed in one pass.
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

/// An estimated mean. An exact value has variance 0.
struct Estimate {
  double mean = 0;
  double variance_of_mean = 0;
};
/// Welch z-test of many pairs of means at the family-wise rate alpha (Šidák), plus a signed z-test
/// of the sum, for which the pairs must be independent.
KINOME_EXPORT Verdict z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b, double alpha);

/// The same without the test of the sum. The pairs may be correlated, such as the channels of a
/// colour, and may include sums.
KINOME_EXPORT Verdict largest_z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                                     double alpha);

}  // namespace kinome::check

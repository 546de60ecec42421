#include "kit/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace kinome::check {

double chi2_tail(double statistic, int degrees_of_freedom) {
  const double x = statistic / 2;
  if (!(x > 0)) return 1;
  // Q(a, x) with a = degrees_of_freedom / 2, from Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1)
  // (Abramowitz and Stegun, 6.5.21).
  const bool is_odd = degrees_of_freedom % 2 != 0;
  double q = is_odd ? std::erfc(std::sqrt(x)) : std::exp(-x);
  for (double a = is_odd ? 0.5 : 1; a < 0.5 * degrees_of_freedom; ++a) {
    q += std::exp(a * std::log(x) - x - std::lgamma(a + 1));
  }
  return q;
}

double normal_two_sided(double z) {
  return std::erfc(std::abs(z) / std::numbers::sqrt2);
}

Verdict chi2_test(const std::vector<double>& observed, const std::vector<double>& expected,
                  double alpha) {
  if (observed.size() != expected.size()) {
    return fail(fmt::format("there are {} observations for {} expectations", observed.size(),
                            expected.size()));
  }
  constexpr double kSmall = 5;
  double total_observed = 0, total_expected = 0;
  double pooled_observed = 0, pooled_expected = 0;
  double statistic = 0;
  int cells = 0;
  size_t smallest = 0;
  for (size_t i = 0; i < observed.size(); ++i) {
    if (!(expected[i] >= 0) || !std::isfinite(expected[i])) {
      return fail(fmt::format("cell {} has the expectation {}", i, expected[i]));
    }
    if (expected[i] == 0) {
      if (observed[i] != 0) {
        return fail(
            fmt::format("{} samples in cell {}, where the density is zero", observed[i], i));
      }
      continue;
    }
    total_observed += observed[i];
    total_expected += expected[i];
    if (expected[i] < kSmall) {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
      continue;
    }
    if (cells == 0 || expected[i] < expected[smallest]) {
      smallest = i;
    }
    statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
    ++cells;
  }
  if (std::abs(total_observed - total_expected) > 1e-4 * total_observed) {
    return fail(
        fmt::format("{} samples, but the expectations sum to {}", total_observed, total_expected));
  }
  if (pooled_expected > 0 && pooled_expected < kSmall && cells > 0) {
    const double o = observed[smallest];
    const double e = expected[smallest];
    statistic -= (o - e) * (o - e) / e;
    pooled_observed += o;
    pooled_expected += e;
    --cells;
  }
  if (pooled_expected > 0) {
    const double d = pooled_observed - pooled_expected;
    statistic += d * d / pooled_expected;
    ++cells;
  }
  if (cells < 2) {
    return {true, 1, "all samples are in one cell"};
  }
  const double p = chi2_tail(statistic, cells - 1);
  return {p >= alpha, p,
          fmt::format("chi2 = {:.5g} with {} degrees of freedom, p = {:.3g}, alpha = {:.3g}",
                      statistic, cells - 1, p, alpha)};
}

namespace {

/// Differences between pairs of means, in units of their standard deviation.
struct PairStatistics {
  double largest = -1;  ///< |z|
  size_t where = 0;     ///< index of the pair with the largest |z|
  double sum = 0, sum_variance = 0;
  std::string fault;  ///< reason why the means can't be compared; "" if they can

  PairStatistics(const std::vector<Estimate>& a, const std::vector<Estimate>& b) {
    if (a.size() != b.size() || a.empty()) {
      fault = fmt::format("the numbers of means must be equal and positive, got {} and {}",
                          a.size(), b.size());
      return;
    }
    for (size_t i = 0; i < a.size() && fault.empty(); ++i) add(i, a[i], b[i]);
  }
  /// Returns Šidák's 1 - (1 - p)^n, without cancellation.
  double p_value(size_t pairs) const {
    return -std::expm1(static_cast<double>(pairs) * std::log1p(-normal_two_sided(largest)));
  }

 private:
  void add(size_t i, const Estimate& a, const Estimate& b) {
    const double difference = a.mean - b.mean;
    // Means of floats have rounding errors, however small their variance is.
    const double rounding = 1e-6 * std::max(std::abs(a.mean), std::abs(b.mean));
    const double variance = a.variance_of_mean + b.variance_of_mean + rounding * rounding;
    if (!std::isfinite(difference) || !std::isfinite(variance) || variance < 0) {
      fault = fmt::format("pair {} is not finite: {} and {}", i, a.mean, b.mean);
      return;
    }
    const double z = difference == 0 ? 0 : std::abs(difference) / std::sqrt(variance);
    if (z > largest) {
      largest = z;
      where = i;
    }
    sum += difference;
    sum_variance += variance;
  }
};

std::string text_of(const PairStatistics& found, const std::vector<Estimate>& a,
                    const std::vector<Estimate>& b) {
  return fmt::format("largest |z| = {:.3f} of {} pairs, at {}: {:.6g} against {:.6g}",
                     found.largest, a.size(), found.where, a[found.where].mean,
                     b[found.where].mean);
}

}  // namespace

Verdict z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b, double alpha) {
  const PairStatistics found(a, b);
  if (!found.fault.empty()) return fail(found.fault);
  const double z_sum = found.sum == 0 ? 0 : found.sum / std::sqrt(found.sum_variance);
  const double p = bonferroni(found.p_value(a.size()), normal_two_sided(z_sum));
  return {p >= alpha, p,
          fmt::format("{}; the sum's z = {:.3f}; p = {:.3g}, alpha = {:.3g}",
                      text_of(found, a, b), z_sum, p, alpha)};
}

Verdict largest_z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                       double alpha) {
  const PairStatistics found(a, b);
  if (!found.fault.empty()) return fail(found.fault);
  const double p = found.p_value(a.size());
  return {p >= alpha, p,
          fmt::format("{}; p = {:.3g}, alpha = {:.3g}", text_of(found, a, b), p, alpha)};
}

}  // namespace kinome::check

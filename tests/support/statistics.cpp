#include "support/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

namespace kinome::test {

namespace {

/// Q(a, x) = Gamma(a, x) / Gamma(a): the series of P = 1 - Q below x = a + 1, Lentz's continued
/// fraction above (Abramowitz and Stegun, 6.5.29 and 6.5.31). About 1e-13 relative for a < 1e5.
double upper_incomplete_gamma(double a, double x) {
  if (!(x > 0)) {
    return 1;
  }
  const double front = std::exp(a * std::log(x) - x - std::lgamma(a));
  constexpr int kMaxTerms = 100000;
  constexpr double kEpsilon = 1e-15;
  if (x < a + 1) {
    double term = 1 / a;
    double sum = term;
    for (int n = 1; n < kMaxTerms && term > kEpsilon * sum; ++n) {
      term *= x / (a + n);
      sum += term;
    }
    return 1 - front * sum;
  }
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a;
  double c = 1 / kTiny;
  double d = 1 / b;
  double fraction = d;
  for (int n = 1; n < kMaxTerms; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = numerator * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + numerator / c;
    c = std::abs(c) < kTiny ? kTiny : c;
    fraction *= d * c;
    if (std::abs(d * c - 1) < kEpsilon) {
      break;
    }
  }
  return front * fraction;
}

Verdict fail(std::string text) {
  return {false, 0, std::move(text)};
}

/// The p-value of the more suspicious of two tests, so that both together alarm at rate alpha.
double bonferroni(double p, double q) {
  return std::min(1., 2 * std::min(p, q));
}

/// Direction at cos theta = z and azimuth phi.
Vec3 sphere_point(double z, double phi) {
  const double r = std::sqrt(std::max(0., 1 - z * z));
  return Vec3(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
              static_cast<float>(z));
}

/// A rectangle in (cos theta, phi), where the measure is solid angle.
struct Patch {
  double z0, z1, phi0, phi1;

  Patch part(int i, int j, int n) const {
    const double dz = (z1 - z0) / n;
    const double dphi = (phi1 - phi0) / n;
    return {z0 + i * dz, z0 + (i + 1) * dz, phi0 + j * dphi, phi0 + (j + 1) * dphi};
  }
};

/// Adaptive cubature of a density over patches of the sphere.
class PatchIntegral {
 public:
  /// tolerance: absolute, of the integral over one cell.
  PatchIntegral(const std::function<float(const Vec3&)>& pdf, double tolerance)
      : pdf_(pdf), tolerance_(tolerance) {}

  double operator()(const Patch& cell, int panels) const {
    double sum = 0;
    for (int i = 0; i < panels; ++i) {
      for (int j = 0; j < panels; ++j) {
        const Patch panel = cell.part(i, j, panels);
        sum += refine(panel, gauss(panel), tolerance_ / panels, kMaxDepth);
      }
    }
    return sum;
  }

 private:
  static constexpr int kMaxDepth = 7;

  /// Gauss-Legendre, 4 x 4 nodes.
  double gauss(const Patch& p) const {
    static constexpr std::array kNode{0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                                      0.93056815579702629};
    static constexpr std::array kWeight{0.17392742256872693, 0.32607257743127307,
                                        0.32607257743127307, 0.17392742256872693};
    double sum = 0;
    for (size_t i = 0; i < 4; ++i) {
      for (size_t j = 0; j < 4; ++j) {
        const Vec3 d =
            sphere_point(p.z0 + kNode[i] * (p.z1 - p.z0), p.phi0 + kNode[j] * (p.phi1 - p.phi0));
        sum += kWeight[i] * kWeight[j] * pdf_(d);
      }
    }
    return sum * (p.z1 - p.z0) * (p.phi1 - p.phi0);
  }

  double refine(const Patch& p, double coarse, double tolerance, int depth) const {
    std::array<double, 4> parts;
    double fine = 0;
    for (int i = 0; i < 4; ++i) {
      parts[i] = gauss(p.part(i / 2, i % 2, 2));
      fine += parts[i];
    }
    if (depth == 0 || !(std::abs(fine - coarse) > tolerance)) {
      return fine;
    }
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      // Errors of the four parts are independent: halving keeps their sum's size.
      sum += refine(p.part(i / 2, i % 2, 2), parts[i], tolerance / 2, depth - 1);
    }
    return sum;
  }

  const std::function<float(const Vec3&)>& pdf_;
  double tolerance_;
};

/// |d direction / du x d direction / dv| by central differences with step h and, as `error`, its
/// relative change from step 2h. Derivatives are extrapolated to fourth order.
struct FiniteDifference {
  double area = 0;
  double error = 0;
};

using DVec3 = glm::dvec3;

std::optional<FiniteDifference> surface_element(
    const std::function<std::optional<Vec3>(Vec2)>& sample, const Vec2& u, float h) {
  std::array<std::array<DVec3, 2>, 2> derivative;  // [step][axis]
  for (int step = 0; step < 2; ++step) {
    for (int axis = 0; axis < 2; ++axis) {
      Vec2 lo = u;
      Vec2 hi = u;
      const float size = step == 0 ? 2 * h : h;
      lo[axis] -= size;
      hi[axis] += size;
      const auto a = sample(lo);
      const auto b = sample(hi);
      if (!a || !b) {
        return std::nullopt;
      }
      derivative[step][axis] =
          (DVec3(*b) - DVec3(*a)) / (static_cast<double>(hi[axis]) - static_cast<double>(lo[axis]));
    }
  }
  const double coarse = glm::length(glm::cross(derivative[0][0], derivative[0][1]));
  const double fine = glm::length(glm::cross(derivative[1][0], derivative[1][1]));
  const DVec3 du = (4. * derivative[1][0] - derivative[0][0]) / 3.;
  const DVec3 dv = (4. * derivative[1][1] - derivative[0][1]) / 3.;
  return FiniteDifference{glm::length(glm::cross(du, dv)), std::abs(coarse / fine - 1)};
}

}  // namespace

double chi2_tail(double statistic, double degrees_of_freedom) {
  return upper_incomplete_gamma(degrees_of_freedom / 2, statistic / 2);
}

double normal_two_sided(double z) {
  return std::erfc(std::abs(z) / std::numbers::sqrt2);
}

Verdict chi2_test(const std::vector<double>& observed, const std::vector<double>& expected,
                  double alpha) {
  if (observed.size() != expected.size()) {
    return fail("as many observations as expectations are needed");
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
    return {true, 1, "one cell holds everything"};
  }
  const double p = chi2_tail(statistic, cells - 1);
  return {p >= alpha, p,
          fmt::format("chi2 = {:.5g} with {} degrees of freedom, p = {:.3g}, alpha = {:.3g}",
                      statistic, cells - 1, p, alpha)};
}

Verdict sphere_chi2_test(const SphereChi2& test, double alpha) {
  const int rows = test.res_theta;
  const int columns = 2 * rows;
  std::vector<double> observed(static_cast<size_t>(rows) * columns);
  std::mt19937 bits(static_cast<uint32_t>(test.seed * 2654435761u + 12345));
  const auto random = [&] { return static_cast<float>(bits() >> 8) * 0x1p-24f; };
  std::vector<Vec3> last(observed.size());  // in each cell
  double accepted = 0;
  for (int i = 0; i < test.samples; ++i) {
    const float u1 = random();
    const float ux = random();
    const float uy = random();
    const auto d = test.sample(u1, Vec2(ux, uy));
    if (!d) {
      continue;
    }
    if (!is_finite(*d) || std::abs(glm::dot(*d, *d) - 1) > 1e-4f) {
      return fail(fmt::format("sample({}, {}, {}) is no unit vector", u1, ux, uy));
    }
    const double phi = std::atan2(d->y, d->x) / (2 * std::numbers::pi);
    const int row = std::clamp(static_cast<int>((d->z + 1.) / 2 * rows), 0, rows - 1);
    const int column =
        std::clamp(static_cast<int>((phi < 0 ? phi + 1 : phi) * columns), 0, columns - 1);
    const size_t cell = static_cast<size_t>(row) * columns + column;
    ++observed[cell];
    last[cell] = *d;
    ++accepted;
  }

  std::vector<double> expected(observed.size());
  double mass = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const int row = static_cast<int>(i) / columns;
    const int column = static_cast<int>(i) % columns;
    const Patch cell{2. * row / rows - 1, 2. * (row + 1) / rows - 1,
                     2 * std::numbers::pi * column / columns,
                     2 * std::numbers::pi * (column + 1) / columns};
    // An error of 1 % of the noise of the cell's count adds nothing visible to the statistic.
    const double tolerance = 0.01 * std::sqrt(observed[i] + 1) / test.samples;
    const PatchIntegral integral(test.pdf, tolerance);
    const int panels = std::max(1, test.subdivide / 4);
    double value = integral(cell, panels);
    const double difference = std::abs(value * test.samples - observed[i]);
    if (difference > 3 * std::sqrt(observed[i] + 1)) {
      // Maybe a peak narrower than the first nodes' distance: look closer before blaming the code.
      value = integral(cell, 8 * panels);
    }
    if (value == 0 && observed[i] > 0 && test.pdf(last[i]) > 0) {
      // The cell's sliver of density lies between all nodes: it belongs to the pooled cells.
      value = 1e-3 / test.samples;
    }
    expected[i] = value;
    mass += value;
  }

  // The number of accepted samples is binomial; given it, the cells are multinomial.
  const double rejected = test.samples - accepted;
  const double expected_rejected = test.samples * (1 - mass);
  const double cubature_error = 1e-4 * test.samples;
  const double z = (rejected - expected_rejected) /
                   std::sqrt(std::max(expected_rejected, 0.) * std::min(mass, 1.) +
                             cubature_error * cubature_error);
  const double p_mass = normal_two_sided(z);
  if (accepted == 0 || !(mass > 0)) {
    return {accepted == 0 && p_mass >= alpha, p_mass, "no sample was accepted"};
  }
  for (double& e : expected) {
    e *= accepted / mass;
  }
  Verdict verdict = chi2_test(observed, expected, alpha / 2);
  verdict.p_value = bonferroni(verdict.p_value, p_mass);
  verdict.passed = verdict.passed && p_mass >= alpha / 2;
  verdict.text += fmt::format("; the density integrates to {:.6f}, {:.6f} of the samples accepted",
                              mass, accepted / test.samples);
  return verdict;
}

Verdict jacobian_test(const std::function<std::optional<Vec3>(Vec2)>& sample,
                      const std::function<float(const Vec3&)>& pdf, int count, double tolerance,
                      uint64_t seed) {
  // Balances the rounding of float directions (1e-7 / h) and the error of order h^4.
  constexpr float kStep = 1.f / 512;
  constexpr double kUnreliable = 0.02;
  std::mt19937 bits(static_cast<uint32_t>(seed));
  std::uniform_real_distribution<float> random(2.5f * kStep, 1 - 2.5f * kStep);
  std::vector<double> errors;
  int accepted = 0;
  Vec2 worst_u{0.f};
  double worst = -1;
  for (int i = 0; i < count; ++i) {
    const float x = random(bits);
    const Vec2 u{x, random(bits)};
    const auto direction = sample(u);
    if (!direction) {
      continue;
    }
    ++accepted;
    const auto element = surface_element(sample, u, kStep);
    if (!element || !(element->error < kUnreliable)) {
      continue;
    }
    const double error = std::abs(pdf(*direction) * element->area - 1);
    errors.push_back(error);
    if (!(error <= worst)) {
      worst = error;
      worst_u = u;
    }
  }
  if (accepted == 0 || errors.size() * 2 < static_cast<size_t>(accepted)) {
    return fail(fmt::format("only {} of {} points have a reliable difference quotient",
                            errors.size(), accepted));
  }
  std::sort(errors.begin(), errors.end());
  const double median = errors[errors.size() / 2];
  const double high = errors[errors.size() * 95 / 100];
  const bool passed = median <= tolerance && high <= 10 * tolerance;
  return {
      passed, passed ? 1. : 0.,
      fmt::format("|pdf x area - 1|: median {:.3g}, 95 % {:.3g}, largest {:.3g} at u = ({}, {})",
                  median, high, worst, worst_u.x, worst_u.y)};
}

Verdict z_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b, double alpha) {
  if (a.size() != b.size() || a.empty()) {
    return fail("as many means on both sides are needed, at least one");
  }
  double largest = -1;
  size_t where = 0;
  double sum = 0, sum_variance = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double difference = a[i].mean - b[i].mean;
    // Means of floats carry their rounding, however small the variance is.
    const double rounding = 1e-6 * std::max(std::abs(a[i].mean), std::abs(b[i].mean));
    const double variance = a[i].variance_of_mean + b[i].variance_of_mean + rounding * rounding;
    if (!std::isfinite(difference) || !std::isfinite(variance) || variance < 0) {
      return fail(fmt::format("pair {} is not finite: {} and {}", i, a[i].mean, b[i].mean));
    }
    const double z = difference == 0 ? 0 : std::abs(difference) / std::sqrt(variance);
    if (z > largest) {
      largest = z;
      where = i;
    }
    sum += difference;
    sum_variance += variance;
  }
  // Šidák: 1 - (1 - p)^n, without cancellation.
  const double p_pairs =
      -std::expm1(static_cast<double>(a.size()) * std::log1p(-normal_two_sided(largest)));
  const double z_sum = sum == 0 ? 0 : sum / std::sqrt(sum_variance);
  const double p = bonferroni(p_pairs, normal_two_sided(z_sum));
  return {p >= alpha, p,
          fmt::format("largest |z| = {:.3f} of {} pairs, at {}: {:.6g} against {:.6g}; the sum's z "
                      "= {:.3f}; p = {:.3g}, alpha = {:.3g}",
                      largest, a.size(), where, a[where].mean, b[where].mean, z_sum, p, alpha)};
}

}  // namespace kinome::test

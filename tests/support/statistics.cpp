#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "support/statistics.h"

namespace kinome::test {
namespace {

/// Returns the direction with cos theta = z and azimuth phi.
Vec3 sphere_point(double z, double phi) {
  const double r = std::sqrt(std::max(0., 1 - z * z));
  return Vec3(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
              static_cast<float>(z));
}

/// A rectangle in (cos theta, phi), in which area is solid angle.
struct SpherePatch {
  double z0, z1, phi0, phi1;

  SpherePatch part(int i, int j, int n) const {
    const double dz = (z1 - z0) / n;
    const double dphi = (phi1 - phi0) / n;
    return {z0 + i * dz, z0 + (i + 1) * dz, phi0 + j * dphi, phi0 + (j + 1) * dphi};
  }
};

/// Adaptive cubature of a density over patches of the sphere.
class PatchIntegral {
 public:
  /// `tolerance`: maximum absolute error of the integral over one cell.
  PatchIntegral(const std::function<float(const Vec3&)>& pdf, double tolerance)
      : pdf_(pdf), tolerance_(tolerance) {}

  double operator()(const SpherePatch& cell, int panels) const {
    double sum = 0;
    for (int i = 0; i < panels; ++i) {
      for (int j = 0; j < panels; ++j) {
        const SpherePatch panel = cell.part(i, j, panels);
        sum += refine(panel, gauss(panel), tolerance_ / panels, kMaxDepth);
      }
    }
    return sum;
  }

 private:
  static constexpr int kMaxDepth = 7;

  /// Gauss-Legendre quadrature with 4 x 4 nodes.
  double gauss(const SpherePatch& p) const {
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

  double refine(const SpherePatch& p, double coarse, double tolerance, int depth) const {
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
      // The errors of the four parts are independent, so half the tolerance is enough for each.
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

/// Samples, counted in cells that are equal in z and phi: test.res_theta rows and twice as many
/// columns.
struct SphereCounts {
  std::vector<double> observed;
  std::vector<Vec3> last;  ///< last sample of each cell
  double accepted = 0;     ///< number of samples
  std::string error;       ///< set if a sample is invalid
};
SphereCounts count_samples(const SphereChi2& test) {
  const int rows = test.res_theta, columns = 2 * rows;
  SphereCounts counts;
  counts.observed.resize(static_cast<size_t>(rows) * columns);
  counts.last.resize(counts.observed.size());
  std::mt19937 bits(static_cast<uint32_t>(test.seed * 2654435761u + 12345));
  const auto random = [&] { return static_cast<float>(bits() >> 8) * 0x1p-24f; };
  for (int i = 0; i < test.samples; ++i) {
    const float u1 = random();
    const float ux = random();
    const float uy = random();
    const auto d = test.sample(u1, Vec2(ux, uy));
    if (!d) {
      continue;
    }
    if (!is_finite(*d) || std::abs(glm::dot(*d, *d) - 1) > 1e-4f) {
      counts.error = fmt::format("sample({}, {}, {}) is not a unit vector", u1, ux, uy);
      return counts;
    }
    const double phi = std::atan2(d->y, d->x) / (2 * std::numbers::pi);
    const int row = std::clamp(static_cast<int>((d->z + 1.) / 2 * rows), 0, rows - 1);
    const int column =
        std::clamp(static_cast<int>((phi < 0 ? phi + 1 : phi) * columns), 0, columns - 1);
    const size_t cell = static_cast<size_t>(row) * columns + column;
    ++counts.observed[cell];
    counts.last[cell] = *d;
    ++counts.accepted;
  }
  return counts;
}

/// Returns the integral of the density over each cell of `counts`.
std::vector<double> integrate_cells(const SphereChi2& test, const SphereCounts& counts) {
  const int rows = test.res_theta, columns = 2 * rows;
  const std::vector<double>& observed = counts.observed;
  std::vector<double> expected(observed.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    const int row = static_cast<int>(i) / columns;
    const int column = static_cast<int>(i) % columns;
    const SpherePatch cell{2. * row / rows - 1, 2. * (row + 1) / rows - 1,
                     2 * std::numbers::pi * column / columns,
                     2 * std::numbers::pi * (column + 1) / columns};
    // An error of 1 % of the noise of the cell's count doesn't affect the statistic.
    const double tolerance = 0.01 * std::sqrt(observed[i] + 1) / test.samples;
    const PatchIntegral integral(test.pdf, tolerance);
    const int panels = std::max(1, test.subdivide / 4);
    double value = integral(cell, panels);
    const double difference = std::abs(value * test.samples - observed[i]);
    if (difference > 3 * std::sqrt(observed[i] + 1)) {
      // The nodes may have missed a narrow peak. Integrate with more nodes before reporting a
      // fault.
      value = integral(cell, 8 * panels);
    }
    if (value == 0 && observed[i] > 0 && test.pdf(counts.last[i]) > 0) {
      // The density is not 0 only between the nodes. Give the cell a small value, so it is pooled.
      value = 1e-3 / test.samples;
    }
    expected[i] = value;
  }
  return expected;
}

}  // namespace

Verdict sphere_chi2_test(const SphereChi2& test, double alpha) {
  const SphereCounts counts = count_samples(test);
  if (!counts.error.empty()) return fail(counts.error);
  std::vector<double> expected = integrate_cells(test, counts);
  double mass = 0;
  for (const double e : expected) mass += e;

  // The number of accepted samples is binomial; given it, the cells are multinomial.
  const double accepted = counts.accepted, rejected = test.samples - accepted;
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
  Verdict verdict = chi2_test(counts.observed, expected, alpha / 2);
  verdict.p_value = bonferroni(verdict.p_value, p_mass);
  verdict.passed = verdict.passed && p_mass >= alpha / 2;
  verdict.text += fmt::format("; the density integrates to {:.6f}, {:.6f} of the samples accepted",
                              mass, accepted / test.samples);
  return verdict;
}

Verdict jacobian_test(const std::function<std::optional<Vec3>(Vec2)>& sample,
                      const std::function<float(const Vec3&)>& pdf, int count, double tolerance,
                      uint64_t seed) {
  // Balances the rounding error of float directions (1e-7 / h) and the truncation error (h^4).
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

double detectable_bias(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                       double alpha) {
  double sum = 0, variance = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += b[i].mean;
    variance += a[i].variance_of_mean + b[i].variance_of_mean;
  }
  // z_test gives the sum one half of the false-alarm rate.
  double low = 0, high = 40;
  while (high - low > 1e-6) {
    const double z = (low + high) / 2;
    (normal_two_sided(z) > alpha / 2 ? low : high) = z;
  }
  constexpr double kQuantile90 = 1.2816;  // 90 % quantile of the normal distribution
  return (high + kQuantile90) * std::sqrt(variance) / std::abs(sum);
}

}  // namespace kinome::test

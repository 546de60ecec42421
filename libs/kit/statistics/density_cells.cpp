#include "kit/statistics/density_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace kinome::check {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// A direction in coordinates in which area is proportional to solid angle.
struct Point {
  double z, phi;
};

/// Computes z from x and y near the poles, where a float is not accurate enough.
Point point_of(const Vec3& d) {
  const double across = double{d.x} * double{d.x} + double{d.y} * double{d.y};
  const double z = double{d.z};
  const double near = 1 - across / (1 + std::sqrt(std::max(0., 1 - across)));
  const double phi = std::atan2(double{d.y}, double{d.x});
  return {across < 0.5 ? std::copysign(near, z) : z, phi < 0 ? phi + kTwoPi : phi};
}

Vec3 direction_of(const Point& point) {
  const double r = std::sqrt(std::max(0., (1 - point.z) * (1 + point.z)));
  return Vec3(static_cast<float>(r * std::cos(point.phi)),
              static_cast<float>(r * std::sin(point.phi)), static_cast<float>(point.z));
}

struct Cell {
  double z0, z1, phi0, phi1;
  double q = 0;       ///< constant density in the cell
  size_t firsts = 0;  ///< number of the first samples, which defined the cells, in this cell
  // Sums over samples, then over uniform directions.
  double sampled = 0, sampled_squares = 0, sampled_rest = 0, found = 0;
  double stated = 0, stated_squares = 0, stated_rest = 0, mass = 0;

  double solid_angle() const { return (z1 - z0) * (phi1 - phi0); }
};

/// Cells, and a binary tree to find them.
class Cells {
 public:
  explicit Cells(std::vector<Point> firsts) : total_(firsts.size()) {
    divide({-1, 1, 0, kTwoPi}, firsts.begin(), firsts.end(), 0);
  }
  Cell& at(const Vec3& d) {
    const Point point = point_of(d);
    size_t node = 0;
    while (nodes_[node].cell < 0) {
      const Node& n = nodes_[node];
      node = (n.by_z ? point.z : point.phi) < n.middle ? n.lower : n.upper;
    }
    return cells_[static_cast<size_t>(nodes_[node].cell)];
  }
  std::vector<Cell>& all() { return cells_; }

 private:
  using Iterator = std::vector<Point>::iterator;
  struct Node {
    int cell = -1;
    bool by_z = false;
    double middle = 0;
    size_t lower = 0, upper = 0;
  };

  size_t divide(const Cell& cell, Iterator first, Iterator last, int depth) {
    constexpr int kMinDepth = 5, kMaxDepth = 44;  // the smallest angles are about 1e-6
    constexpr size_t kMaxSamples = 40;
    const auto firsts = static_cast<size_t>(last - first);
    const size_t index = nodes_.size();
    nodes_.emplace_back();
    if (depth >= kMinDepth && (firsts <= kMaxSamples || depth == kMaxDepth)) {
      nodes_[index].cell = static_cast<int>(cells_.size());
      cells_.push_back(cell);
      cells_.back().firsts = firsts;
      cells_.back().q =
          (static_cast<double>(firsts) + 0.5) / static_cast<double>(total_) / cell.solid_angle();
      return index;
    }
    // Split the longer side, as measured on the sphere.
    const double z = (cell.z0 + cell.z1) / 2, sine = std::sqrt(std::max(0., 1 - z * z));
    const double height = std::acos(cell.z0) - std::acos(cell.z1);
    const bool by_z = height > (cell.phi1 - cell.phi0) * sine;
    Cell lower = cell, upper = cell;
    const double middle = by_z ? z : (cell.phi0 + cell.phi1) / 2;
    (by_z ? lower.z1 : lower.phi1) = (by_z ? upper.z0 : upper.phi0) = middle;
    const Iterator split =
        std::partition(first, last, [&](const Point& p) { return (by_z ? p.z : p.phi) < middle; });
    const size_t below = divide(lower, first, split, depth + 1);
    const size_t above = divide(upper, split, last, depth + 1);
    nodes_[index] = {-1, by_z, middle, below, above};
    return index;
  }

  size_t total_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
};

/// Returns a / (a + b).
double fraction(double a, double b) {
  return a / (a + b);
}

constexpr int kGrid = 8, kUniform = kGrid * kGrid;  ///< uniform directions in each cell

/// Computes the sums over uniform directions of each cell.
void integrate(const DensityCells& test, Cells& cells, Random& random) {
  for (Cell& cell : cells.all()) {
    const double weight = cell.q * cell.solid_angle() / kUniform;
    for (int i = 0; i < kUniform; ++i) {
      const double s = (i % kGrid + double{random.unit()}) / kGrid;
      const double t = (static_cast<double>(i / kGrid) + double{random.unit()}) / kGrid;
      const double p = std::max(0., test.pdf(direction_of(
                                        {cell.z0 + s * (cell.z1 - cell.z0),
                                         cell.phi0 + t * (cell.phi1 - cell.phi0)})));
      const double stated = std::isfinite(p) ? fraction(p, cell.q) : 1;
      cell.stated += weight * stated;
      cell.stated_squares += weight * stated * stated;
      cell.stated_rest += weight * stated * (1 - stated);
      cell.mass += cell.solid_angle() * p / kUniform;
    }
  }
}

/// Returns the means of a cell and their variances. With s = q / (q + p) and t = 1 - s, the second
/// moments can be estimated from either side:
///     E_samples[1_c s²] = ∫_c q E_uniform[s t],     ∫_c q E_uniform[t²] = E_samples[1_c s t].
/// The averages of both are used: if one side happens to miss a small peak, its own estimate of the
/// variance would be far too small.
std::pair<Estimate, Estimate> estimates_of(const Cell& cell, double samples) {
  const double of_samples = (cell.sampled_squares + cell.stated_rest) / 2;
  const double of_uniform = (cell.stated_squares + cell.sampled_rest) / 2;
  const double weight = cell.q * cell.solid_angle(), mean = (cell.sampled + cell.stated) / 2;
  return {{cell.sampled, of_samples / samples},
          {cell.stated, std::max(0., weight * of_uniform - mean * mean) / kUniform}};
}

/// Adds each cell's fraction of the samples, by count and by the stated density, to `sampled` and
/// `stated`, and the sums and the worst cell to `verdict`.
void add_cells(Cells& cells, double n, std::vector<Estimate>& sampled,
               std::vector<Estimate>& stated, DensityVerdict& verdict) {
  // Cells with few samples are pooled, because their sums aren't normally distributed.
  constexpr double kMinSamples = 12;
  Estimate rest_sampled, rest_stated;
  double largest = -1;
  for (const Cell& cell : cells.all()) {
    verdict.accepted += cell.found;
    verdict.mass += cell.mass;
    const auto [a, b] = estimates_of(cell, n);
    if (static_cast<double>(cell.firsts) < kMinSamples) {
      rest_sampled.mean += a.mean, rest_sampled.variance_of_mean += a.variance_of_mean;
      rest_stated.mean += b.mean, rest_stated.variance_of_mean += b.variance_of_mean;
      continue;
    }
    sampled.push_back(a);
    stated.push_back(b);
    const double z2 =
        (a.mean - b.mean) * (a.mean - b.mean) / (a.variance_of_mean + b.variance_of_mean + 1e-30);
    if (z2 > largest) {
      largest = z2;
      verdict.worst = direction_of({(cell.z0 + cell.z1) / 2, (cell.phi0 + cell.phi1) / 2});
      verdict.worst_sampled = cell.found;
      verdict.worst_expected = cell.mass;
    }
  }
  if (rest_sampled.mean + rest_stated.mean > 0) {
    // A single sample more or less than expected must not make the test fail.
    rest_sampled.variance_of_mean += 1 / (n * n);
    sampled.push_back(rest_sampled);
    stated.push_back(rest_stated);
  }
  if (sampled.empty()) {
    sampled.push_back({0, 1e-12});
    stated.push_back({0, 1e-12});
  }
}

}  // namespace

Verdict mean_squares_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                          double alpha) {
  if (a.size() != b.size() || a.empty()) {
    return fail(fmt::format("the numbers of means must be equal and positive, got {} and {}",
                            a.size(), b.size()));
  }
  double statistic = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double d = a[i].mean - b[i].mean;
    const double rounding = 1e-5 * std::max(std::abs(a[i].mean), std::abs(b[i].mean));
    const double variance = a[i].variance_of_mean + b[i].variance_of_mean + rounding * rounding;
    if (!std::isfinite(d) || !std::isfinite(variance)) return fail("a mean is not finite");
    if (d != 0) statistic += d * d / variance;
  }
  const double p = chi2_tail(statistic, static_cast<int>(a.size()));
  return {p >= alpha, p,
          fmt::format("chi2 {:.1f} for {} cells, p {:.2g}, bound {:.1g}", statistic, a.size(), p,
                      alpha)};
}

DensityVerdict density_test(const DensityCells& test, double alpha) {
  Random random(test.seed);
  std::vector<Point> firsts;
  DensityVerdict verdict;
  const auto draw = [&](const auto& use) {
    const auto d = test.sample(random);
    if (!d) return true;
    if (!is_finite(*d) || std::abs(glm::dot(*d, *d) - 1) > 1e-3f) return false;
    use(*d);
    return true;
  };
  const auto no_unit_vector = [&] {
    static_cast<Verdict&>(verdict) = fail("a sample's direction is not a unit vector");
    return verdict;
  };
  for (int i = 0; i < test.samples / 3; ++i) {
    if (!draw([&](const Vec3& d) { firsts.push_back(point_of(d)); })) return no_unit_vector();
  }
  if (firsts.empty()) firsts.push_back({0, 0});
  Cells cells(std::move(firsts));
  integrate(test, cells, random);
  const double n = test.samples;
  for (int i = 0; i < test.samples; ++i) {
    const bool is_unit = draw([&](const Vec3& d) {
      Cell& cell = cells.at(d);
      const double p = test.pdf(d);
      const double x = std::isfinite(p) ? fraction(cell.q, std::max(0., p)) : 0;
      cell.sampled += x / n;
      cell.sampled_squares += x * x / n;
      cell.sampled_rest += x * (1 - x) / n;
      cell.found += 1 / n;
    });
    if (!is_unit) return no_unit_vector();
  }
  std::vector<Estimate> sampled, stated;
  add_cells(cells, n, sampled, stated, verdict);
  static_cast<Verdict&>(verdict) = mean_squares_test(sampled, stated, alpha);
  return verdict;
}

}  // namespace kinome::check

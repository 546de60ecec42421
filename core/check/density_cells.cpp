#include "check/density_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "check/verdicts.h"

namespace kinome::check {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// A direction by the two numbers in which solid angle is even.
struct Place {
  double z, phi;
};

/// z is found from x and y near the poles, where it is too close to 1 for a float.
Place place_of(const Vec3& d) {
  const double across = double{d.x} * double{d.x} + double{d.y} * double{d.y};
  const double z = double{d.z};
  const double near = 1 - across / (1 + std::sqrt(std::max(0., 1 - across)));
  const double phi = std::atan2(double{d.y}, double{d.x});
  return {across < 0.5 ? std::copysign(near, z) : z, phi < 0 ? phi + kTwoPi : phi};
}

Vec3 direction_of(const Place& place) {
  const double r = std::sqrt(std::max(0., (1 - place.z) * (1 + place.z)));
  return Vec3(static_cast<float>(r * std::cos(place.phi)),
              static_cast<float>(r * std::sin(place.phi)), static_cast<float>(place.z));
}

struct Cell {
  double z0, z1, phi0, phi1;
  double q = 0;       ///< a density, the same all over the cell
  size_t firsts = 0;  ///< samples that made the cells
  // Sums over samples, then over even directions.
  double sampled = 0, sampled_squares = 0, sampled_rest = 0, found = 0;
  double told = 0, told_squares = 0, told_rest = 0, mass = 0;

  double solid_angle() const { return (z1 - z0) * (phi1 - phi0); }
};

/// Cells, and a binary tree that finds them.
class Cells {
 public:
  explicit Cells(std::vector<Place> firsts) : total_(firsts.size()) {
    divide({-1, 1, 0, kTwoPi}, firsts.begin(), firsts.end(), 0);
  }
  Cell& at(const Vec3& d) {
    const Place place = place_of(d);
    size_t node = 0;
    while (nodes_[node].cell < 0) {
      const Node& n = nodes_[node];
      node = (n.by_z ? place.z : place.phi) < n.middle ? n.lower : n.upper;
    }
    return cells_[static_cast<size_t>(nodes_[node].cell)];
  }
  std::vector<Cell>& all() { return cells_; }

 private:
  using Iterator = std::vector<Place>::iterator;
  struct Node {
    int cell = -1;
    bool by_z = false;
    double middle = 0;
    size_t lower = 0, upper = 0;
  };

  size_t divide(const Cell& cell, Iterator first, Iterator last, int depth) {
    constexpr int kLeastDepth = 5, kMostDepth = 44;  // angles of some 1e-6
    constexpr size_t kMostSamples = 40;
    const auto firsts = static_cast<size_t>(last - first);
    const size_t index = nodes_.size();
    nodes_.emplace_back();
    if (depth >= kLeastDepth && (firsts <= kMostSamples || depth == kMostDepth)) {
      nodes_[index].cell = static_cast<int>(cells_.size());
      cells_.push_back(cell);
      cells_.back().firsts = firsts;
      cells_.back().q =
          (static_cast<double>(firsts) + 0.5) / static_cast<double>(total_) / cell.solid_angle();
      return index;
    }
    // Across the longer side, as seen on the sphere.
    const double z = (cell.z0 + cell.z1) / 2, sine = std::sqrt(std::max(0., 1 - z * z));
    const double height = std::acos(cell.z0) - std::acos(cell.z1);
    const bool by_z = height > (cell.phi1 - cell.phi0) * sine;
    Cell lower = cell, upper = cell;
    const double middle = by_z ? z : (cell.phi0 + cell.phi1) / 2;
    (by_z ? lower.z1 : lower.phi1) = (by_z ? upper.z0 : upper.phi0) = middle;
    const Iterator split = std::partition(
        first, last, [&](const Place& p) { return (by_z ? p.z : p.phi) < middle; });
    const size_t below = divide(lower, first, split, depth + 1);
    const size_t above = divide(upper, split, last, depth + 1);
    nodes_[index] = {-1, by_z, middle, below, above};
    return index;
  }

  size_t total_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
};

double share(double of, double other) {
  return of / (of + other);
}

constexpr int kSide = 8, kEven = kSide * kSide;  ///< directions in each cell

/// What even directions of each cell say that the samples are.
void integrate(const DensityCells& test, Cells& cells, Random& random) {
  for (Cell& cell : cells.all()) {
    const double weight = cell.q * cell.solid_angle() / kEven;
    for (int i = 0; i < kEven; ++i) {
      const double s = (i % kSide + double{random.unit()}) / kSide;
      const double t = (static_cast<double>(i / kSide) + double{random.unit()}) / kSide;
      const double p = std::max(0., test.pdf(direction_of(
                                        {cell.z0 + s * (cell.z1 - cell.z0),
                                         cell.phi0 + t * (cell.phi1 - cell.phi0)})));
      const double told = std::isfinite(p) ? share(p, cell.q) : 1;
      cell.told += weight * told;
      cell.told_squares += weight * told * told;
      cell.told_rest += weight * told * (1 - told);
      cell.mass += cell.solid_angle() * p / kEven;
    }
  }
}

/// Means of a cell with their variances. With s = q / (q + p) and t = 1 - s, second moments can be had
/// from either side:
///     E_samples[1_c s²] = ∫_c q E_even[s t],     ∫_c q E_even[t²] = E_samples[1_c s t],
/// and are taken from both: from one alone, a side that happens to miss a sliver of light would be
/// taken to be sure of it.
std::pair<Estimate, Estimate> estimates_of(const Cell& cell, double samples) {
  const double of_samples = (cell.sampled_squares + cell.told_rest) / 2;
  const double of_even = (cell.told_squares + cell.sampled_rest) / 2;
  const double weight = cell.q * cell.solid_angle(), mean = (cell.sampled + cell.told) / 2;
  return {{cell.sampled, of_samples / samples},
          {cell.told, std::max(0., weight * of_even - mean * mean) / kEven}};
}

}  // namespace

Verdict mean_squares_test(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                          double alpha) {
  if (a.size() != b.size() || a.empty()) return fail("as many means on both sides are needed");
  double statistic = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double d = a[i].mean - b[i].mean;
    const double rounding = 1e-5 * std::max(std::abs(a[i].mean), std::abs(b[i].mean));
    const double variance = a[i].variance_of_mean + b[i].variance_of_mean + rounding * rounding;
    if (!std::isfinite(d) || !std::isfinite(variance)) return fail("a mean is not finite");
    if (d != 0) statistic += d * d / variance;
  }
  const auto degrees = static_cast<double>(a.size());
  const double p = chi2_tail(statistic, degrees);
  return {p >= alpha, p, fmt::format("chi2 {:.1f} of {} cells, p {:.2g}, bound {:.1g}", statistic,
                                     a.size(), p, alpha)};
}

DensityVerdict density_test(const DensityCells& test, double alpha) {
  Random random(test.seed);
  std::vector<Place> firsts;
  DensityVerdict verdict;
  int tries = 0;
  const auto draw = [&](const auto& use) {
    ++tries;
    const auto d = test.sample(random);
    if (!d) return true;
    if (!is_finite(*d) || std::abs(glm::dot(*d, *d) - 1) > 1e-3f) return false;
    use(*d);
    return true;
  };
  const auto no_unit_vector = [&] {
    static_cast<Verdict&>(verdict) = fail("a sample's direction is no unit vector");
    return verdict;
  };
  for (int i = 0; i < test.samples / 3; ++i) {
    if (!draw([&](const Vec3& d) { firsts.push_back(place_of(d)); })) return no_unit_vector();
  }
  if (firsts.empty()) firsts.push_back({0, 0});
  Cells cells(std::move(firsts));
  integrate(test, cells, random);
  const double n = test.samples;
  for (int i = 0; i < test.samples; ++i) {
    const bool is_unit = draw([&](const Vec3& d) {
      Cell& cell = cells.at(d);
      const double p = test.pdf(d);
      const double x = std::isfinite(p) ? share(cell.q, std::max(0., p)) : 0;
      cell.sampled += x / n;
      cell.sampled_squares += x * x / n;
      cell.sampled_rest += x * (1 - x) / n;
      cell.found += 1 / n;
    });
    if (!is_unit) return no_unit_vector();
  }
  // Cells of few samples are put together, since sums of few are far from normal.
  constexpr double kFew = 12;
  std::vector<Estimate> sampled, told;
  Estimate rest_sampled, rest_told;
  double largest = -1;
  for (const Cell& cell : cells.all()) {
    verdict.accepted += cell.found;
    verdict.mass += cell.mass;
    const auto [a, b] = estimates_of(cell, n);
    if (static_cast<double>(cell.firsts) < kFew) {
      rest_sampled.mean += a.mean, rest_sampled.variance_of_mean += a.variance_of_mean;
      rest_told.mean += b.mean, rest_told.variance_of_mean += b.variance_of_mean;
      continue;
    }
    sampled.push_back(a);
    told.push_back(b);
    const double z2 =
        (a.mean - b.mean) * (a.mean - b.mean) / (a.variance_of_mean + b.variance_of_mean + 1e-30);
    if (z2 > largest) {
      largest = z2;
      verdict.worst = direction_of({(cell.z0 + cell.z1) / 2, (cell.phi0 + cell.phi1) / 2});
      verdict.worst_sampled = cell.found;
      verdict.worst_told = cell.mass;
    }
  }
  if (rest_sampled.mean + rest_told.mean > 0) {
    // One sample more or less than expected must not decide.
    rest_sampled.variance_of_mean += 1 / (n * n);
    sampled.push_back(rest_sampled);
    told.push_back(rest_told);
  }
  if (sampled.empty()) {
    sampled.push_back({0, 1e-12});
    told.push_back({0, 1e-12});
  }
  static_cast<Verdict&>(verdict) = mean_squares_test(sampled, told, alpha);
  return verdict;
}

}  // namespace kinome::check

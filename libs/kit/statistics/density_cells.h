#pragma once

#include <functional>
#include <optional>

#include "kit/statistics/random.h"
#include "kit/statistics/statistics.h"

namespace kinome::check {

/// Test of whether sampled directions follow the density that a function states, whatever its
/// shape. It uses cells of the sphere, which are small where samples are dense, down to a sun of
/// half a degree.
///
/// The first samples define the cells. For each cell c, let q be a constant density that gives
/// about the same number of samples, and p the stated density. Then
///     E_samples[1_c q / (q + p)] = ∫_c p q / (q + p) = ∫_c q E_uniform[p / (q + p)].
/// All terms are in [0, 1], so edges and peaks within a cell don't disturb the test.
struct DensityCells {
  /// Returns a direction. nullopt if sampling fails; the density then integrates to less than 1.
  std::function<std::optional<Vec3>(Random&)> sample;
  std::function<double(const Vec3&)> pdf;  ///< per solid angle
  int samples = 30000;                     ///< without those that define the cells, a third as many
  uint64_t seed = 1;
};

struct DensityVerdict : Verdict {
  double accepted = 0;        ///< fraction of calls that returned a sample
  double mass = 0;            ///< estimate of the density's integral
  Vec3 worst{0.f};            ///< direction in the cell that deviates most
  double worst_sampled = 0;   ///< fraction of the samples in that cell
  double worst_expected = 0;  ///< the same fraction according to the stated density
};
KINOME_EXPORT DensityVerdict density_test(const DensityCells& test, double alpha);

/// Tests whether pairs of means, one for each cell, have the same expectations. The statistic is
/// the sum of the squared differences over their variances, compared with chi². The pairs must be
/// independent or negatively correlated.
KINOME_EXPORT Verdict mean_squares_test(const std::vector<Estimate>& a,
                                        const std::vector<Estimate>& b, double alpha);

}  // namespace kinome::check

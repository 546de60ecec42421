#pragma once

#include <functional>
#include <optional>

#include "check/random.h"
#include "check/statistics.h"

namespace kinome::check {

/// Whether sampled directions follow the density that is told of them, however it is shaped: by
/// cells of the sphere that are small where samples are dense, down to a sun of half a degree.
///
/// Cells are made by the first samples. In each cell c, with q a constant density of about as many
/// samples, and p the density that is told,
///     E_samples[1_c q / (q + p)] = ∫_c p q / (q + p) = ∫_c q E_even[p / (q + p)],
/// where all terms lie within [0, 1], so that edges and peaks within a cell spoil nothing.
struct DensityCells {
  /// nullopt: no sample was had; the density then integrates to less than 1.
  std::function<std::optional<Vec3>(Random&)> sample;
  std::function<double(const Vec3&)> pdf;  ///< per solid angle
  int samples = 30000;                     ///< and a third as many that make the cells
  uint64_t seed = 1;
};

struct DensityVerdict : Verdict {
  double accepted = 0;  ///< the share of tries that gave a sample
  double mass = 0;      ///< about what the density integrates to
  Vec3 worst{0.f};      ///< a direction in the cell that deviates most
  double worst_sampled = 0, worst_told = 0;  ///< the cell's share of the samples, and what is told
};
KINOME_EXPORT DensityVerdict density_test(const DensityCells& test, double alpha);

/// Whether pairs of means, each of a cell and independent of one another or less than that, have
/// the same expectations: by the sum of squared differences over their variances, as chi².
KINOME_EXPORT Verdict mean_squares_test(const std::vector<Estimate>& a,
                                        const std::vector<Estimate>& b, double alpha);

}  // namespace kinome::check

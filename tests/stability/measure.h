#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kinome/plugin_registry.h"
#include "kinome/scene.h"
#include "support/statistics.h"

/// Repeated renders and their statistics: mean, spread, tails, and the number of values that aren't
/// finite.
namespace kinome::test {

/// Measures of an estimator's tails. The samples are pixel values of the renders. Film and sampler
/// must use one sample per pixel, so that these are single contributions.
struct Tails {
  double kurtosis = 0;  ///< of the deviations from pixel means: 3 for a normal distribution
  double largest = 0;   ///< largest absolute value as a fraction of the sum of all absolute values
};

/// Renders of one scene with consecutive seeds.
struct Renders {
  int width = 0, height = 0;
  std::vector<std::vector<float>> pixels;  ///< R, G, B of all pixels, for each render
  uint64_t non_finite = 0;  ///< samples that the film rejected, and values of the image
  Tails tails() const;
  /// Returns sums over tiles x tiles parts of the image, R, G, B each, for render `i`.
  std::vector<double> sums(size_t i, int tiles) const;
};
Renders render_often(const Scene& scene, int renders, uint64_t first_seed, unsigned threads = 1);

/// Result of comparing two sets of means: the largest |z| and its p-value.
struct Agreement {
  double worst_z = 0;  ///< as for a normal distribution, over all tiles and channels
  double p = 1;        ///< of the whole comparison: by tile (Šidák), channel and sum (Bonferroni)
  /// True if one side of the worst pair has a variance from hardly any values, which may be too
  /// small by chance because most renders don't find the light.
  bool is_open = false;
  bool has_more = false;  ///< true if the first value of that pair is the larger one
  std::string text;       ///< position and values
};

/// A mean of independent values, with the reliability of its variance.
struct TileEstimate {
  Estimate estimate;
  double freedom = 0;  ///< degrees of freedom of the variance; infinite if it is exact
  /// Effective number of values that determine the variance: a third of their number if they are
  /// normal, 1 for a single outlier, 0 if all are equal.
  double spread = 0;
};

/// Returns sums over tiles x tiles parts for all renders, channel by channel.
std::vector<TileEstimate> estimate_tiles_of(const Renders& renders, int tiles);
/// Returns the same for differences between two sets of renders with the same seeds.
std::vector<TileEstimate> estimate_tile_differences(const Renders& a, const Renders& b, int tiles);
/// Returns the expectations of pixels (R, G, B each, in the order of an image) and their errors, as
/// tiles.
std::vector<TileEstimate> exact_tiles(const std::vector<Estimate>& pixels, int width, int height,
                                      int tiles);

/// Returns the expectation of differences.
std::vector<TileEstimate> exact_zeros(size_t count);

/// Welch's test of all pairs. Variances of a few dozen renders are uncertain, so that a quantile of
/// Student's t is converted to one of the normal distribution (Wallace 1959). Rounding may change a
/// value by the fraction kRounding of `scale`, which has one value per pair (empty: the larger of
/// both means), and by kFaint, because factors of such faint values leave single precision.
inline constexpr double kRounding = 2e-6, kFaint = 1e-31;
Agreement compare(const std::vector<TileEstimate>& a, const std::vector<TileEstimate>& b,
                  const std::vector<double>& scale = {}, double rounding = kRounding);

}  // namespace kinome::test

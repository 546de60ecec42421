#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kinome/plugin_registry.h"
#include "kinome/scene.h"
#include "support/statistics.h"

/// Pictures rendered again and again, and what they say of an estimator: mean, spread, tails, and
/// the values that were no numbers.
namespace kinome::test {

/// How heavy an estimator's tails are. Of pixels' values, renders being the samples: film and
/// sampler are to take one sample a pixel, so that these are single contributions.
struct Tails {
  double kurtosis = 0;  ///< of what differs from the pixel's mean: 3 for a normal distribution
  double largest = 0;   ///< share of the largest value in the sum of the absolute values of all
};

/// Renders of one scene with consecutive seeds.
struct Renders {
  int width = 0, height = 0;
  std::vector<std::vector<float>> pixels;  ///< of each render: R, G, B of all pixels
  uint64_t non_finite = 0;  ///< samples that the film refused, and values of the picture
  Tails tails() const;
  /// Sums over tiles x tiles parts of the picture, R, G, B each, of render `i`.
  std::vector<double> sums(size_t i, int tiles) const;
};
Renders render_often(const Scene& scene, int renders, uint64_t first_seed, unsigned threads = 1);

/// Of two sets of means: the largest |z|, and the chance of what is at least as suspicious.
struct Agreement {
  double worst_z = 0;  ///< as of a normal distribution, of all tiles and channels
  double p = 1;        ///< of the whole comparison: by tile (Šidák), channel and sum (Bonferroni)
  /// True where the worst pair has a side whose variance comes from hardly any values, so that it
  /// is too small by chance: of light that most renders don't find.
  bool is_open = false;
  bool has_more = false;  ///< whether that pair's first is the larger one
  std::string text;       ///< where, and what was seen there
};

/// A mean of some independent values, whose number tells how far its variance can be trusted.
struct TileEstimate {
  Estimate estimate;
  double freedom = 0;  ///< degrees of freedom of the variance; infinite where it is known
  /// About how many values the variance comes from: a third of their number where they are normal,
  /// 1 where one outlier makes it, 0 where all are the same.
  double spread = 0;
};

/// Tiles x tiles sums of all renders, channel by channel.
std::vector<TileEstimate> estimate_tiles_of(const Renders& renders, int tiles);
/// The same of the differences of two sets of renders of the same seeds.
std::vector<TileEstimate> estimate_tile_differences(const Renders& a, const Renders& b, int tiles);
/// Pixels' expectations (R, G, B each, in the order of an image) and their errors, as tiles.
std::vector<TileEstimate> exact_tiles(const std::vector<Estimate>& pixels, int width, int height,
                                      int tiles);

/// What differences are to be.
std::vector<TileEstimate> exact_zeros(size_t count);

/// Welch's test of all pairs. Variances of a few dozen renders are uncertain themselves: a
/// quantile of Student's t is taken for what it is of the normal distribution (Wallace 1959).
/// Rounding may have moved a value by that part of `scale`, for each pair in its own unit (empty:
/// the larger of both means), and by kFaint: factors of what is so faint leave single precision.
inline constexpr double kRounding = 2e-6, kFaint = 1e-31;
Agreement compare(const std::vector<TileEstimate>& a, const std::vector<TileEstimate>& b,
                  const std::vector<double>& scale = {}, double rounding = kRounding);

}  // namespace kinome::test

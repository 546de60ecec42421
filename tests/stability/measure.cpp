#include "measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinome/render.h"
#include "kinome/render_context.h"
#include "kit/statistics/statistics.h"

namespace kinome::test {
namespace {

/// Converts t with `freedom` degrees of freedom to a quantile of the normal distribution (Wallace
/// 1959, "Bounds on Normal Approximations to Student's and the Chi-Square Distributions").
double normal_quantile_of(double t, double freedom) {
  if (!(freedom < 1e6)) return t;
  const double z =
      (8 * freedom + 1) / (8 * freedom + 3) * std::sqrt(freedom * std::log1p(t * t / freedom));
  return std::copysign(z, t);
}

struct Difference {
  double z = 0;
  double mean = 0;
};
/// `rounding`: as a standard deviation. Means of floats have rounding errors, however small their
/// variance.
Difference difference_of(const TileEstimate& a, const TileEstimate& b, double rounding) {
  const double va = a.estimate.variance_of_mean, vb = b.estimate.variance_of_mean;
  const double variance = va + vb + rounding * rounding;
  const double difference = a.estimate.mean - b.estimate.mean;
  if (difference == 0) return {};
  // Welch and Satterthwaite.
  const auto part = [](double v, double freedom) { return freedom > 0 ? v * v / freedom : 0; };
  const double denominator = part(va, a.freedom) + part(vb, b.freedom);
  const double freedom =
      denominator > 0 ? variance * variance / denominator : std::numeric_limits<double>::infinity();
  return {normal_quantile_of(difference / std::sqrt(variance), freedom), difference};
}

/// Spread below which a variance is unreliable.
constexpr double kMinSpread = 6;

/// Sums over tiles of each render, as estimates of their means.
class TileSums {
 public:
  explicit TileSums(int tiles) : values_(static_cast<size_t>(tiles) * tiles * 3) {}
  void add(size_t tile, double value) { values_[tile].push_back(value); }

  std::vector<TileEstimate> estimates() const {
    std::vector<TileEstimate> estimates;
    for (const std::vector<double>& values : values_) {
      Moments moments;
      for (const double v : values) moments.add(v);
      double second = 0, fourth = 0;
      for (const double v : values) {
        const double d = v - moments.mean();
        second += d * d;
        fourth += d * d * d * d;
      }
      estimates.push_back({{moments.mean(), moments.variance_of_mean()},
                           static_cast<double>(moments.count()) - 1,
                           fourth > 0 ? second * second / fourth : 0});
    }
    return estimates;
  }

 private:
  std::vector<std::vector<double>> values_;
};

/// Returns true if a's variance is or may be too small: it comes from few values, or is 0 while b
/// varies. Exact values have no such variance.
bool has_unreliable_variance(const TileEstimate& a, const TileEstimate& b) {
  if (!std::isfinite(a.freedom)) return false;
  if (a.estimate.variance_of_mean == 0) return b.estimate.variance_of_mean > 0 && b.freedom > 0;
  return a.spread < kMinSpread;
}

}  // namespace

Tails Renders::tails() const {
  if (pixels.empty()) return {};
  double second = 0, fourth = 0, sum = 0, largest = 0;
  const auto count = static_cast<double>(pixels.size());
  for (size_t i = 0; i < pixels[0].size(); ++i) {
    double mean = 0;
    for (const auto& render : pixels) {
      mean += render[i];
      sum += std::abs(render[i]);
      largest = std::max<double>(largest, std::abs(render[i]));
    }
    mean /= count;
    for (const auto& render : pixels) {
      const double d2 = (render[i] - mean) * (render[i] - mean);
      second += d2;
      fourth += d2 * d2;
    }
  }
  const double values = count * static_cast<double>(pixels[0].size());
  Tails tails;
  // Rounding errors have no significant tails.
  if (second > 1e-12 * sum * sum / values) tails.kurtosis = values * fourth / (second * second);
  if (sum > 0) tails.largest = largest / sum;
  return tails;
}

std::vector<double> Renders::sums(size_t i, int tiles) const {
  std::vector<double> sums(static_cast<size_t>(tiles) * tiles * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int tile = y * tiles / height * tiles + x * tiles / width;
      for (int c = 0; c < 3; ++c) sums[3 * tile + c] += pixels[i][3 * (y * width + x) + c];
    }
  }
  return sums;
}

Renders render_often(const Scene& scene, int renders, uint64_t first_seed, unsigned threads) {
  Renders result;
  for (int i = 0; i < renders; ++i) {
    RenderOptions options;
    options.seed = first_seed + static_cast<uint64_t>(i);
    options.threads = threads;
    RenderContext context(options);
    const Image image = render(scene, *scene.sensors().at(0), context);
    result.width = image.width;
    result.height = image.height;
    result.non_finite += context.job.stats().non_finite_samples;
    std::vector<float> pixels;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          const float value = image.at(x, y, c);
          result.non_finite += !std::isfinite(value);
          pixels.push_back(value);
        }
      }
    }
    result.pixels.push_back(std::move(pixels));
  }
  return result;
}

std::vector<TileEstimate> estimate_tiles_of(const Renders& renders, int tiles) {
  TileSums all(tiles);
  for (size_t i = 0; i < renders.pixels.size(); ++i) {
    const std::vector<double> sums = renders.sums(i, tiles);
    for (size_t k = 0; k < sums.size(); ++k) all.add(k, sums[k]);
  }
  return all.estimates();
}

std::vector<TileEstimate> estimate_tile_differences(const Renders& a, const Renders& b, int tiles) {
  TileSums all(tiles);
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const std::vector<double> left = a.sums(i, tiles), right = b.sums(i, tiles);
    for (size_t k = 0; k < left.size(); ++k) all.add(k, left[k] - right[k]);
  }
  return all.estimates();
}

std::vector<TileEstimate> exact_zeros(size_t count) {
  TileEstimate zero;
  zero.freedom = zero.spread = std::numeric_limits<double>::infinity();
  return std::vector<TileEstimate>(count, zero);
}

std::vector<TileEstimate> exact_tiles(const std::vector<Estimate>& pixels, int width, int height,
                                      int tiles) {
  std::vector<TileEstimate> sums(static_cast<size_t>(tiles) * tiles * 3);
  std::vector<double> errors(sums.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int tile = y * tiles / height * tiles + x * tiles / width;
      for (int c = 0; c < 3; ++c) {
        const Estimate& pixel = pixels[3 * (static_cast<size_t>(y) * width + x) + c];
        sums[3 * tile + c].estimate.mean += pixel.mean;
        // Errors of an integral are similar in all pixels: they add up, not their squares.
        errors[3 * tile + c] += std::sqrt(pixel.variance_of_mean);
      }
    }
  }
  for (size_t k = 0; k < sums.size(); ++k) {
    sums[k].estimate.variance_of_mean = errors[k] * errors[k];
    sums[k].freedom = sums[k].spread = std::numeric_limits<double>::infinity();
  }
  return sums;
}

Agreement compare(const std::vector<TileEstimate>& a, const std::vector<TileEstimate>& b,
                  const std::vector<double>& scale, double rounding) {
  Agreement agreement;
  const auto size_of = [&](size_t k) {
    return scale.empty() ? std::max(std::abs(a[k].estimate.mean), std::abs(b[k].estimate.mean))
                         : scale[k];
  };
  for (size_t channel = 0; channel < 3; ++channel) {
    double worst = 0;
    size_t where = channel, pairs = 0;
    TileEstimate sum_a, sum_b;
    double sum_scale = 0;
    const auto add = [](TileEstimate& sum, const TileEstimate& part) {
      sum.estimate.mean += part.estimate.mean;
      sum.estimate.variance_of_mean += part.estimate.variance_of_mean;
      // A lower bound: at least that of the largest part.
      sum.freedom = std::max(sum.freedom, part.freedom);
      sum.spread = std::max(sum.spread, part.spread);
    };
    for (size_t k = channel; k < a.size(); k += 3, ++pairs) {
      const double size = size_of(k) + kFaint / rounding;
      if (!std::isfinite(a[k].estimate.mean) || !std::isfinite(b[k].estimate.mean) ||
          !std::isfinite(a[k].estimate.variance_of_mean + b[k].estimate.variance_of_mean)) {
        agreement.worst_z = std::numeric_limits<double>::infinity();
        agreement.p = 0;
        agreement.text = fmt::format("tile {} is not finite: {} and {}", k / 3, a[k].estimate.mean,
                                     b[k].estimate.mean);
        return agreement;
      }
      const double z = std::abs(difference_of(a[k], b[k], rounding * size).z);
      if (z > worst) {
        worst = z;
        where = k;
      }
      add(sum_a, a[k]);
      add(sum_b, b[k]);
      sum_scale += size;
    }
    const double z_sum = std::abs(difference_of(sum_a, sum_b, rounding * sum_scale).z);
    const double p_tiles =
        -std::expm1(static_cast<double>(pairs) * std::log1p(-normal_two_sided(worst)));
    const double p = bonferroni(p_tiles, normal_two_sided(z_sum));
    agreement.p = std::min(agreement.p, 3 * p);
    if (std::max(worst, z_sum) > agreement.worst_z) {
      agreement.worst_z = std::max(worst, z_sum);
      const bool is_sum = z_sum > worst;
      const TileEstimate& left = is_sum ? sum_a : a[where];
      const TileEstimate& right = is_sum ? sum_b : b[where];
      agreement.is_open =
          has_unreliable_variance(left, right) || has_unreliable_variance(right, left);
      agreement.has_more = left.estimate.mean > right.estimate.mean;
      agreement.text = fmt::format("{}, channel {}: {:.7g} against {:.7g}",
                                   is_sum ? "sum" : fmt::format("tile {}", where / 3), channel,
                                   left.estimate.mean, right.estimate.mean);
    }
  }
  return agreement;
}

}  // namespace kinome::test

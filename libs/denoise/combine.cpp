// Combines a noisy image with a denoised one: see combine_with_noisy().
//
// With r = μ + e for noise e of variance v, and d = μ + β for a bias β that doesn't depend on e,
//
//     E[(r - d)²] = v + β²,        E[(d + a (r - d) - μ)²] = a² v + (1 - a)² β²,
//
// which is least for a = β² / (β² + v). This is James and Stein's estimator, with (r - d)² averaged
// over a window. If d follows the noise, (r - d)² is smaller, and so is a: the error of d is then
// that of the noisy image at most, and still vanishes with v.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kinome/denoise.h"

namespace kinome {
namespace {

constexpr int kRadius = 5;  ///< of the window, in pixels
/// Part of the squared mean brightness of the image that is added to a pixel's, as in relMSE.
constexpr double kMeanFraction = 0.01;

/// Replaces each value by the sum over the window around its pixel.
void sum_over_windows(std::vector<double>& values, int width, int height) {
  const auto sum_lines = [&values](int lines, int length, size_t line_stride, size_t stride) {
    std::vector<double> before(static_cast<size_t>(length) + 1);
    for (int line = 0; line < lines; ++line) {
      double* const first = values.data() + static_cast<size_t>(line) * line_stride;
      before[0] = 0;
      for (size_t i = 0; i < static_cast<size_t>(length); ++i) {
        before[i + 1] = before[i] + first[i * stride];
      }
      for (int i = 0; i < length; ++i) {
        const auto low = static_cast<size_t>(std::max(i - kRadius, 0));
        const auto high = static_cast<size_t>(std::min(i + kRadius + 1, length));
        first[static_cast<size_t>(i) * stride] = before[high] - before[low];
      }
    }
  };
  sum_lines(height, width, static_cast<size_t>(width), 1);
  sum_lines(width, height, 1, static_cast<size_t>(width));
}

double squared_sum(const float* rgb) {
  const double sum = double{rgb[0]} + rgb[1] + rgb[2];
  return sum * sum / 3;
}

}  // namespace

std::vector<float> combine_with_noisy(std::span<const float> noisy, std::span<const float> variance,
                                      std::span<const float> denoised, int width, int height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  double mean = 0;
  for (const float value : denoised) mean += double{value} / static_cast<double>(3 * pixels);
  const double min_brightness = kMeanFraction * 3 * mean * mean;
  // Sums over channels, relative to the squared brightness, and weights that limit the influence of
  // single pixels with much noise.
  std::vector<double> difference(pixels), noise(pixels), weight(pixels), own(pixels);
  for (size_t p = 0; p < pixels; ++p) {
    const double brightness = squared_sum(&denoised[3 * p]) + min_brightness;
    double squares = 0, variances = 0;
    for (size_t i = 3 * p; i < 3 * p + 3; ++i) {
      const double d = double{noisy[i]} - denoised[i];
      squares += d * d;
      variances += variance[i];
    }
    own[p] = brightness > 0 ? std::max(variances, 0.) / brightness : 0;
    if (!std::isfinite(squares)) own[p] = std::numeric_limits<double>::infinity();
    if (!std::isfinite(own[p])) continue;
    weight[p] = 1 / (1 + own[p]);
    difference[p] = brightness > 0 ? weight[p] * squares / brightness : 0;
    noise[p] = weight[p] * own[p];
  }
  for (auto* const sums : {&difference, &noise, &weight}) sum_over_windows(*sums, width, height);
  std::vector<float> result(denoised.begin(), denoised.end());
  for (size_t p = 0; p < pixels; ++p) {
    if (!(weight[p] > 0) || !std::isfinite(own[p])) continue;
    const double bias = std::max(0., difference[p] - noise[p]) / weight[p];
    if (bias == 0) continue;
    const double share = bias / (bias + std::max(own[p], noise[p] / weight[p]));
    for (size_t i = 3 * p; i < 3 * p + 3; ++i) {
      result[i] += static_cast<float>(share * (double{noisy[i]} - denoised[i]));
    }
  }
  return result;
}

}  // namespace kinome

#include "spherical_map.h"

#include <array>
#include <cmath>
#include <numbers>

namespace kinome {
namespace {

constexpr double kPiD = std::numbers::pi;

/// Maps with fewer rows are refined, which doesn't change the interpolated radiance.
constexpr int kMinRows = 33;

/// Minimum fraction of a texel's weight after MIS compensation. The density must not be zero where
/// there is light, so that estimates without BSDF sampling stay unbiased (but noisy). A larger
/// value wastes rays of estimates with BSDF sampling: with 1/16, scene noon has 11 times the error.
constexpr float kCompensationFloor = 1 / 1024.f;

/// Minimum density of texels that aren't black. Far enough from denormals that interpolated values
/// don't vanish.
constexpr float kMinDensity = 1e-30f;

/// Integrals of sin theta and of (theta - origin) sin theta over [a, b].
struct SineMoments {
  double zeroth;
  double first;
};
SineMoments sine_moments(double a, double b, double origin) {
  const double zeroth = std::cos(a) - std::cos(b);
  const double theta = std::sin(b) - b * std::cos(b) - std::sin(a) + a * std::cos(a);
  return {zeroth, theta - origin * zeroth};
}

}  // namespace

SphericalMap::SphericalMap(const Image& image, float scale, bool compensate) {
  fill(image, scale);
  set_weights(compensate);
}

void SphericalMap::fill(const Image& image, float scale) {
  width_ = image.width;
  const int gaps = std::max(1, image.height - 1);
  const int refine = (kMinRows - 1 + gaps - 1) / gaps;
  height_ = gaps * refine + 1;
  row_angle_ = static_cast<float>(kPiD / (height_ - 1));
  sines_.resize(height_);
  texels_.resize(static_cast<size_t>(height_) * (width_ + 1));
  const bool grey = image.channel_count() < 3;
  const auto read = [&](int x, int y) {
    return grey ? Rgb(image.at(x, y, 0))
                : Rgb(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
  };
  for (int i = 0; i < height_; ++i) {
    sines_[i] =
        i == 0 || i + 1 == height_ ? 0.f : static_cast<float>(std::sin(kPiD * i / (height_ - 1)));
    const int above = i / refine;
    const int below = std::min(above + 1, image.height - 1);
    const float t = static_cast<float>(i % refine) / static_cast<float>(refine);
    Texel* const out = texels_.data() + static_cast<size_t>(i) * (width_ + 1);
    for (int j = 0; j < width_; ++j) {
      const Rgb a = read(j, std::min(above, image.height - 1));
      out[j].radiance = scale * (t == 0 ? a : a * (1 - t) + read(j, below) * t);
    }
    out[width_].radiance = out[0].radiance;
  }
}

void SphericalMap::set_weights(bool compensate) {
  // The solid angle of each row's texels, from patches with interpolated sines; then the integral
  // of the absolute luminance.
  double total = 0, sphere = 0;
  std::vector<double> row_angles(height_);
  for (int i = 0; i < height_; ++i) {
    const double before = i > 0 ? sines_[i - 1] : 0, after = i + 1 < height_ ? sines_[i + 1] : 0;
    const double own = i == 0 || i + 1 == height_ ? 1 : 2;
    row_angles[i] = (own * sines_[i] / 3 + (before + after) / 6) * row_angle_ * 2 * kPiD / width_;
  }
  const auto sum_up = [&](auto&& weight) {
    total = 0;
    for (int i = 0; i < height_; ++i) {
      double sum = 0;
      Texel* const texel = texels_.data() + static_cast<size_t>(i) * (width_ + 1);
      for (int j = 0; j < width_; ++j) sum += texel[j].weight = weight(texel[j]);
      texel[width_].weight = texel[0].weight;
      total += sum * row_angles[i];
    }
  };
  sum_up([](const Texel& texel) { return luminance(glm::abs(texel.radiance)); });
  for (const double angle : row_angles) sphere += angle * width_;
  if (compensate) {
    const auto mean = static_cast<float>(total / sphere);
    sum_up([mean](const Texel& texel) {
      return std::max(texel.weight - mean, kCompensationFloor * texel.weight);
    });
  }
  if (!(total > 0)) return;  // a black map: all densities are 0
  const double norm = 1 / total;
  sum_up([norm](const Texel& texel) {
    const auto density = static_cast<float>(texel.weight * norm);
    return texel.weight > 0 ? std::max(density, kMinDensity) : 0.f;
  });

  std::vector<float> patches(static_cast<size_t>(width_) * (height_ - 1));
  for (int i = 0; i + 1 < height_; ++i) {
    const Texel* const top = row(i);
    const Texel* const bottom = row(i + 1);
    float* const out = patches.data() + static_cast<size_t>(i) * width_;
    const float top_share = sines_[i] / 3 + sines_[i + 1] / 6;
    const float bottom_share = sines_[i] / 6 + sines_[i + 1] / 3;
    for (int j = 0; j < width_; ++j) {
      out[j] = (top[j].weight + top[j + 1].weight) * top_share +
               (bottom[j].weight + bottom[j + 1].weight) * bottom_share;
    }
  }
  patches_ = GridDistribution(width_, height_ - 1, std::move(patches));
}

void SphericalMap::copy_texels(int row_index, int first, std::span<Rgb> radiance) const {
  const Texel* const texels = row(row_index) + first;
  for (size_t i = 0; i < radiance.size(); ++i) radiance[i] = texels[i].radiance;
}

void SphericalMap::integrate_ring(double theta0, double theta1,
                                  std::vector<glm::vec4>& columns) const {
  const double angle = kPiD / (height_ - 1);
  const int first = std::clamp(static_cast<int>(theta0 / angle), 0, height_ - 2);
  const int last = std::clamp(static_cast<int>(theta1 / angle), 0, height_ - 2);
  std::fill(columns.begin(), columns.end(), glm::vec4(0.f));
  double carried = 0;  // contribution of the strip above to this strip's upper row
  for (int i = first; i <= last + 1; ++i) {
    double share = carried;
    carried = 0;
    const double a = std::max(theta0, i * angle), b = std::min(theta1, (i + 1) * angle);
    if (i <= last && b > a) {
      const SineMoments moments = sine_moments(a, b, i * angle);
      carried = moments.first / angle;
      share += moments.zeroth - carried;
    }
    const auto factor = static_cast<float>(share);
    const Texel* const texels = row(i);
    for (int j = 0; j <= width_; ++j) {
      columns[j] += factor * glm::vec4(texels[j].radiance, texels[j].weight);
    }
  }
}

std::vector<Rgb> SphericalMap::integrate(const SpherePartition& cells) const {
  std::vector<Rgb> powers(cells.size());
  std::vector<glm::vec4> columns(width_ + 1);  // four floats like a texel, so that loops vectorise
  const double column_angle = 2 * kPiD / width_;
  double theta0 = 0;
  for (uint32_t ring = 0; ring < cells.ring_count(); ++ring) {
    const uint32_t first = cells.first_of_ring(ring), next = cells.first_of_ring(ring + 1);
    // 1 - cos theta = 2 sin²(theta / 2): precise at both poles.
    const double share = static_cast<double>(next) / cells.size();
    const double theta1 = next == cells.size() ? kPiD : 2 * std::asin(std::sqrt(share));
    integrate_ring(theta0, theta1, columns);
    theta0 = theta1;

    // Along phi, the integrand is linear between columns (column 0 is at half a texel). This visits
    // the borders of cells and columns in order, in units of columns from half a column before
    // column 0.
    int column = width_ - 1;
    double at = -0.5;  // current position, followed by the next column
    double next_column = 0;
    for (uint32_t cell = first; cell < next; ++cell) {
      const double end = static_cast<double>(cell + 1 - first) * width_ / (next - first) - 0.5;
      std::array<double, 3> sum{};
      while (at < end) {
        const double stop = std::min(end, next_column);
        const double s = 0.5 * (at + stop) - (next_column - 1);
        const glm::vec4& a = columns[column];
        const glm::vec4& b = columns[column + 1];
        for (int c = 0; c < 3; ++c) sum[c] += (stop - at) * (a[c] + (b[c] - a[c]) * s);
        at = stop;
        if (stop == next_column) {
          next_column += 1;
          column = column + 1 == width_ ? 0 : column + 1;
        }
      }
      powers[cell] = Rgb(sum[0] * column_angle, sum[1] * column_angle, sum[2] * column_angle);
    }
  }
  return powers;
}

}  // namespace kinome

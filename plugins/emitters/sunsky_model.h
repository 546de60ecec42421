#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "kinome/color.h"
#include "kinome/wide/functions.h"
#include "sunsky_tables.h"

/// The sky of Hošek and Wilkie (An Analytic Model for Full Spectral Sky-Dome Radiance, 2012),
/// fitted to RGB, and the sun of their second paper (2013) as a disk of uniform radiance, as in
/// Mitsuba.
namespace kinome::sunsky {

/// Half of the sun's angular diameter [radians].
inline constexpr double kSolarHalfAngle = 0.5358 / 2 * std::numbers::pi / 180;

/// Fractional position `at` between two rows of a table, clamped to its ends.
struct TablePosition {
  int row;
  float rest;  ///< offset from `row` to the next row, in [0, 1]

  TablePosition(double at, int rows)
      : row(std::clamp(static_cast<int>(std::floor(at)), 0, rows - 2)),
        rest(static_cast<float>(std::clamp(at - row, 0., 1.))) {}
  float between(const float* table, size_t stride, size_t i) const {
    const float* const from = table + static_cast<size_t>(row) * stride + i;
    return from[0] * (1 - rest) + from[stride] * rest;
  }
};

/// Radiance of a cloudless sky, with z up. Immutable; thread-safe.
class Model {
 public:
  /// `turbidity` is in [1, 10], `albedo` (of the ground) in [0, 1], `sun` a unit vector. There is
  /// no light from below the horizon, and none at all if the sun is below it. `rows` is an offset
  /// of positions in the sun's table.
  Model(float turbidity, const Rgb& albedo, const Vec3& sun, double rows = 0)
      : sun_(sun), is_day_(sun.z >= 0) {
    if (!is_day_) return;
    const double elevation = std::asin(std::clamp(double{sun.z}, 0., 1.));
    const TablePosition by_turbidity(turbidity - 1., kTurbidities);
    const std::array<float, kControlPoints> weights = bernstein(elevation);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < kShapeParameters; ++k) {
        channels_[c].shape[k] = interpolated(kSkyShape, kShapeParameters, 3 * k + c, by_turbidity,
                                             albedo[c], weights);
      }
      channels_[c].radiance = interpolated(kSkyRadiance, 1, c, by_turbidity, albedo[c], weights);
      // Rows of the sun's table: 2, 5, … 89 degrees.
      const TablePosition by_elevation((elevation * 180 / std::numbers::pi - 2) / 3 + rows,
                                       kElevations);
      const auto at = [&](int step) {
        const auto row = static_cast<size_t>(by_turbidity.row + step) * kElevations * 3;
        return by_elevation.between(kSunRadiance + row, 3, static_cast<size_t>(c));
      };
      sun_radiance_[c] = at(0) * (1 - by_turbidity.rest) + at(1) * by_turbidity.rest;
    }
  }

  bool is_day() const { return is_day_; }
  const Vec3& sun() const { return sun_; }
  /// Radiance of a sun's disk of half angle kSolarHalfAngle.
  const Rgb& sun_radiance() const { return sun_radiance_; }

  /// Radiance from the direction d above the horizon, without the sun's disk. May be negative for
  /// colours outside the gamut of RGB.
  template <class F>
  wide::formulas::RgbOf<F> sky(const wide::formulas::VecOf<F>& d) const {
    using namespace wide::formulas;
    const F cos_theta = max(d.z, F(0.f));
    const F root = sqrt(cos_theta);
    // From the chord, because the arc cosine is imprecise near 1.
    const F chord = min(0.5f * length(d - VecOf<F>(sun_)), F(1.f));
    const F gamma = 2.f * asin(chord);
    const F cos_gamma = 1.f - 2.f * chord * chord;
    RgbOf<F> result(F(0.f));
    for (int c = 0; c < 3; ++c) {
      const auto& [a, b, k2, k3, k4, k5, k6, k7, g] = channels_[c].shape;
      const F gradation = 1.f + a * exp(b / (cos_theta + 0.01f));
      const F spread = max(1.f + g * g - 2.f * g * cos_gamma, F(1e-12f));
      const F around = (1.f + cos_gamma * cos_gamma) / (spread * sqrt(spread));
      const F scatter = k2 + k3 * exp(k4 * gamma) + k5 * (cos_gamma * cos_gamma) + k6 * around +
                        k7 * root;
      result[c] = gradation * scatter * channels_[c].radiance;
    }
    return result;
  }

 private:
  struct Channel {
    std::array<float, kShapeParameters> shape;
    float radiance = 0;
  };

  /// Weights of the control points: a Bézier curve over the cube root of the sun's elevation, with
  /// most of its points near the horizon.
  static std::array<float, kControlPoints> bernstein(double elevation) {
    constexpr int kDegree = kControlPoints - 1;
    constexpr int kBinomials[] = {1, 5, 10, 10, 5, 1};
    const double x = std::cbrt(elevation * 2 / std::numbers::pi);
    std::array<float, kControlPoints> weights;
    for (int i = 0; i <= kDegree; ++i) {
      weights[i] = static_cast<float>(kBinomials[i] * std::pow(x, i) * std::pow(1 - x, kDegree - i));
    }
    return weights;
  }

  /// Interpolates a table. Entry 3 k + c of a control point is parameter k of channel c.
  static float interpolated(const float* table, size_t parameters, int entry,
                            const TablePosition& by_turbidity, float albedo,
                            const std::array<float, kControlPoints>& weights) {
    const size_t point = 3 * parameters, by_albedo = kControlPoints * point;
    const size_t place = static_cast<size_t>(entry % 3) * parameters + static_cast<size_t>(entry / 3);
    float sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
      const auto at = [&](size_t ground) {
        return by_turbidity.between(table, kAlbedos * by_albedo, ground * by_albedo + i * point + place);
      };
      sum += weights[i] * (at(0) * (1 - albedo) + at(1) * albedo);
    }
    return sum;
  }

  Vec3 sun_;
  bool is_day_;
  std::array<Channel, 3> channels_;
  Rgb sun_radiance_{0.f};
};

}  // namespace kinome::sunsky

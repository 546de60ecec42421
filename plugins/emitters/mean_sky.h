#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "kinome/image.h"
#include "kinome/wide/vectors.h"
#include "sky_settings.h"

/// The mean of the sky over many positions of the sun, as an image for a SphericalMap.
namespace kinome::sunsky {

/// Axes of the map in the sky's space. The map's pole, +y, is the zenith.
inline glm::mat3 mean_sky_axes() {
  return {Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0, 0)};
}

/// Computes the image. A texel is 0.23 degrees wide, less than half of the sun's disk. The sky is
/// computed at every third row and column, and interpolated. The row at the horizon is a mean of
/// sky and ground.
class MeanSky {
 public:
  MeanSky(const SkySettings& settings, double rows)
      : settings_(settings), rows_(rows), image_{kColumns, kRows, {"R", "G", "B"}, {}} {
    image_.data.assign(size_t{kColumns} * kRows * 3, 0.f);
  }

  /// Adds the skies for these directions of the sun, with a total weight of 1, without the sun's
  /// disk.
  void add_skies(std::span<const Vec3> suns) {
    std::vector<Model> models;
    for (const Vec3& sun : suns) {
      const Model model = settings_.model(sun, rows_);
      if (model.is_day()) models.push_back(model);
    }
    const float weight = settings_.sky_scale / static_cast<float>(suns.size());
    const wide::ScratchColumns columns(5, kSkyColumns);
    const Columns3 radiance = columns.three(2);
    for (int i = 0; i < kSkyColumns; ++i) {
      // The centre of every third column of the image.
      const double phi = kColumnAngle * (kStep * i + 0.5);
      columns[0][i] = static_cast<float>(std::cos(phi));
      columns[1][i] = static_cast<float>(std::sin(phi));
    }
    std::vector<Rgb> above, row(kSkyColumns);
    for (int i = 0; i <= kHorizon && weight > 0; i += kStep) {
      const auto cos_theta = static_cast<float>(std::max(0., std::cos(i * kRowAngle)));
      const auto sin_theta = static_cast<float>(std::sin(i * kRowAngle));
      wide::for_lanes(kSkyColumns, [&](size_t k) {
        const wide::Vec3 d(wide::Float::load(columns[0] + k) * -sin_theta,
                           wide::Float::load(columns[1] + k) * sin_theta, wide::Float(cos_theta));
        wide::Rgb sum(wide::Float(0.f));
        for (const Model& model : models) sum = sum + model.sky<wide::Float>(d);
        (sum * wide::Float(weight)).store(radiance, k);
      });
      for (int k = 0; k < kSkyColumns; ++k) {
        row[k] = Rgb(radiance.x[k], radiance.y[k], radiance.z[k]);
      }
      for (int between = 1; between < kStep && i > 0; ++between) {
        const float share = static_cast<float>(between) / kStep;
        add_sky_row(i - kStep + between, 1 - share, above, share, row);
      }
      // The interpolation to the black row below keeps half of the horizon's light above it.
      add_sky_row(i, i == kHorizon ? 0.5f : 1.f, row, 0, row);
      above = row;
    }
  }

  /// Adds these suns with a total weight of 1. Each disk is sampled at some points, whose light is
  /// spread over the texels around them.
  void add_suns(std::span<const Vec3> suns) {
    for (const Vec3& sun : suns) {
      const Model model = settings_.model(sun, rows_);
      if (!model.is_day()) continue;
      const float flux = settings_.sun_scale * settings_.sun_ratio() * settings_.solid_angle() /
                         (kPointsOfSun * static_cast<float>(suns.size()));
      const Frame frame = Frame::from_normal(sun);
      for (int i = 0; i < kPointsOfSun; ++i) {
        // Vogel's spiral: equal areas of the disk.
        const double height = settings_.chord2() / 2 * (i + 0.5) / kPointsOfSun;
        const double radius = std::sqrt(height * (2 - height));
        const double turn = (3 - std::sqrt(5.)) * std::numbers::pi * i;
        add_point(frame.to_world(Vec3(radius * std::cos(turn), radius * std::sin(turn), 1 - height)),
                  model.sun_radiance() * flux);
      }
    }
  }

  const Image& image() const { return image_; }

 private:
  static constexpr int kColumns = 1536, kRows = 769, kHorizon = (kRows - 1) / 2;
  static constexpr int kStep = 3, kSkyColumns = kColumns / kStep;
  static constexpr int kPointsOfSun = 16;
  static_assert(kColumns % kStep == 0 && kHorizon % kStep == 0);
  static constexpr double kRowAngle = std::numbers::pi / (kRows - 1);
  static constexpr double kColumnAngle = 2 * std::numbers::pi / kColumns;

  float* texel(int row, int column) {
    return image_.data.data() + (static_cast<size_t>(row) * kColumns + column) * 3;
  }

  /// Adds weighted rows of kSkyColumns to a row of the image.
  void add_sky_row(int row, float weight_a, const std::vector<Rgb>& a, float weight_b,
                   const std::vector<Rgb>& b) {
    for (int column = 0; column < kColumns; ++column) {
      const int k = column / kStep, next = (k + 1) % kSkyColumns;
      const float share = static_cast<float>(column % kStep) / kStep;
      const Rgb value = (a[k] * (1 - share) + a[next] * share) * weight_a +
                        (b[k] * (1 - share) + b[next] * share) * weight_b;
      for (int c = 0; c < 3; ++c) texel(row, column)[c] += value[c];
    }
  }

  /// Spreads irradiance from the direction d, in the sky's space, over four texels.
  void add_point(const Vec3& d, const Rgb& irradiance) {
    if (d.z < 0) return;
    // Coordinates of the map; see SphericalMap.
    const double theta = std::acos(std::clamp(double{d.z}, -1., 1.));
    const double phi = std::atan2(double{d.y}, double{-d.x});
    const double x = phi / kColumnAngle - 0.5 + kColumns, y = theta / kRowAngle;
    const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(y);
    const auto s = static_cast<float>(x - column), t = static_cast<float>(y - row);
    const auto add = [&](int r, int c, float weight) {
      if (!(weight > 0)) return;
      const double above = std::max(0., (r - 0.5) * kRowAngle), below = (r + 0.5) * kRowAngle;
      const auto solid_angle =
          static_cast<float>((std::cos(above) - std::cos(below)) * kColumnAngle);
      for (int k = 0; k < 3; ++k) {
        texel(r, c % kColumns)[k] += irradiance[k] * (weight / solid_angle);
      }
    };
    add(row, column, (1 - s) * (1 - t));
    add(row, column + 1, s * (1 - t));
    add(row + 1, column, (1 - s) * t);
    add(row + 1, column + 1, s * t);
  }

  SkySettings settings_;
  double rows_;
  Image image_;
};

}  // namespace kinome::sunsky

#pragma once

#include <cmath>
#include <numbers>

#include "kinome/math.h"

namespace kinome {

/// How the radiance of an environment is laid out: quads of equal angles in latitude and longitude.
/// A local direction is d = (sin phi sin theta, cos theta, -cos phi sin theta); quad (x, y) spans
/// phi = 2 pi (x + first_column + [0, 1)) / columns and theta = pi (y + [0, 1)) / rows.
struct EnvironmentGrid {
  int columns = 256;
  int rows = 128;
  float first_column = 0;
  glm::mat3 to_world{1.f};  ///< a rotation or reflection
  /// Radiance is smooth (such as bilinear in phi and theta) within each quad, so that quadrature by
  /// four points is exact for all purposes. Where it isn't, integrals over cells are estimated by
  /// the very points that estimates use: unbiased, with more noise.
  bool smooth_quads = false;
  /// Radiance is the bilinear interpolation, in phi and theta, of that at each quad's corners: then
  /// integrals over cells are exact and quick. Implies smooth_quads.
  bool bilinear_quads = false;
};

/// World direction of a place of the grid, in columns and rows.
inline Vec3 grid_direction(const EnvironmentGrid& grid, double column, double row) {
  constexpr double pi = std::numbers::pi;
  const double phi = (column + static_cast<double>(grid.first_column)) * 2 * pi / grid.columns;
  const double theta = row * pi / grid.rows;
  const double sine = std::sin(theta);
  return grid.to_world * Vec3(static_cast<float>(sine * std::sin(phi)),
                              static_cast<float>(std::cos(theta)),
                              static_cast<float>(-sine * std::cos(phi)));
}

/// Columns and rows that each of the grid's is divided into before its radiance is integrated:
/// quads must be small for quadrature by four points, and cells narrow.
struct GridParts {
  int columns;
  int rows;
};
inline GridParts parts_of(const EnvironmentGrid& grid) {
  constexpr int kMinColumns = 32, kMinRows = 16;
  return {(kMinColumns + grid.columns - 1) / grid.columns, (kMinRows + grid.rows - 1) / grid.rows};
}

}  // namespace kinome

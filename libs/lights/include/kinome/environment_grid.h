#pragma once

#include <cmath>
#include <numbers>

#include "kinome/math.h"

namespace kinome {

/// Grid on which an environment's radiance is defined: quads of equal angles in latitude and
/// longitude. A local direction is d = (sin phi sin theta, cos theta, -cos phi sin theta). Quad (x,
/// y) spans phi = 2 pi (x + first_column + [0, 1)) / columns and theta = pi (y + [0, 1)) / rows.
struct EnvironmentGrid {
  int columns = 256;
  int rows = 128;
  float first_column = 0;
  glm::mat3 to_world{1.f};  ///< rotation or reflection
  /// True if radiance is smooth within each quad (for example bilinear in phi and theta), so that
  /// four-point quadrature is accurate. Otherwise integrals over cells are estimated from the
  /// rendered samples: unbiased, with more noise.
  bool smooth_quads = false;
  /// True if radiance is the bilinear interpolation in phi and theta of its values at the quad's
  /// corners. Integrals over cells are then exact and fast. Implies smooth_quads.
  bool bilinear_quads = false;
  /// True if the radiance between evaluated positions is unknown. Each quad then gets part of its
  /// neighbours' importance, because it may contain the edge of a bright disk.
  bool is_probed = false;
};

/// Returns the world direction of a grid position, in columns and rows.
inline Vec3 grid_direction(const EnvironmentGrid& grid, double column, double row) {
  constexpr double pi = std::numbers::pi;
  const double phi = (column + static_cast<double>(grid.first_column)) * 2 * pi / grid.columns;
  const double theta = row * pi / grid.rows;
  const double sine = std::sin(theta);
  return grid.to_world * Vec3(static_cast<float>(sine * std::sin(phi)),
                              static_cast<float>(std::cos(theta)),
                              static_cast<float>(-sine * std::cos(phi)));
}

/// Number of columns and rows into which each grid column and row is divided before integration.
/// Four-point quadrature needs small quads, and sampling needs narrow cells.
struct GridParts {
  int columns;
  int rows;
};
inline GridParts parts_of(const EnvironmentGrid& grid) {
  constexpr int kMinColumns = 32, kMinRows = 16;
  return {(kMinColumns + grid.columns - 1) / grid.columns, (kMinRows + grid.rows - 1) / grid.rows};
}

}  // namespace kinome

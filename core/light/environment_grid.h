#pragma once

#include <cmath>
#include <numbers>

#include "kinome/light_cells.h"

namespace kinome {

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

/// Columns and rows that each of the grid's is divided into: quads must be small for quadrature by
/// four points, and cells narrow.
struct GridParts {
  int columns;
  int rows;
};
inline GridParts parts_of(const EnvironmentGrid& grid) {
  constexpr int kMinColumns = 32, kMinRows = 16;
  return {(kMinColumns + grid.columns - 1) / grid.columns, (kMinRows + grid.rows - 1) / grid.rows};
}

}  // namespace kinome

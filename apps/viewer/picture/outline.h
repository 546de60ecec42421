#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"
#include "kinome/sensor.h"

namespace kinome::viewer {

/// Outline of the visible part of a shape, as smoothed lines.
struct Outline {
  /// Indices of two of `points`.
  struct Line {
    uint32_t from, to;
  };
  std::vector<Vec2> points;  ///< on the film [pixels of the full film]
  std::vector<Line> lines;
};

/// Grid of square cells over the pixels of a film.
struct CellGrid {
  Vec2 corner{0.f};  ///< upper left corner on the film [pixels]
  float cell = 1;    ///< side of a cell [pixels]
  int columns = 0, rows = 0;

  Vec2 centre(int x, int y) const {
    return corner + cell * (Vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f);
  }
};

/// Returns a grid over `crop`, restricted to the part of the film in which `bounds` are visible.
/// The grid has a margin of one cell within `crop`. It covers all of `crop` if the sensor doesn't
/// see a corner of `bounds`.
CellGrid grid_around(const Aabb& bounds, const Sensor& sensor, const Rect& crop, float cell);

/// Returns the lines between cells with `is_inside` and others. `is_inside` has a value for each
/// cell, row by row. The edge of the grid isn't part of the outline.
Outline outline_of(const std::vector<bool>& is_inside, const CellGrid& grid);

}  // namespace kinome::viewer

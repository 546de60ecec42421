#include "picture/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace kinome::viewer {
namespace {

/// Number of times that each point is averaged with its neighbours, so that steps between cells
/// become smooth lines.
constexpr int kSmoothings = 2;
constexpr uint32_t kNoPoint = ~0u;

/// Lines of marching squares. Their ends are midpoints between neighbouring cells.
class Contour {
 public:
  explicit Contour(const CellGrid& grid)
      : grid_(grid),
        right_(static_cast<size_t>(grid.columns) * grid.rows, kNoPoint),
        below_(right_) {}

  /// Adds the lines between the centres of the cells (x, y) to (x + 1, y + 1). Bit i of `inside` is
  /// set if cell i is inside, clockwise from the upper left.
  void add(int x, int y, unsigned inside) {
    // Pairs of sides with a line between them: 0 above, 1 right, 2 below, 3 left. Diagonal cells
    // are separated.
    static constexpr std::array<std::array<int8_t, 4>, 16> kSides = {
        {{-1, -1, -1, -1}, {3, 0, -1, -1}, {0, 1, -1, -1}, {3, 1, -1, -1},
         {1, 2, -1, -1},   {3, 0, 1, 2},   {0, 2, -1, -1}, {3, 2, -1, -1},
         {2, 3, -1, -1},   {2, 0, -1, -1}, {0, 1, 2, 3},   {2, 1, -1, -1},
         {1, 3, -1, -1},   {1, 0, -1, -1}, {0, 3, -1, -1}, {-1, -1, -1, -1}}};
    const auto& sides = kSides[inside];
    for (size_t i = 0; i < 4 && sides[i] >= 0; i += 2) {
      outline_.lines.push_back({point(x, y, sides[i]), point(x, y, sides[i + 1])});
    }
  }

  Outline smoothed() {
    std::vector<std::array<uint32_t, 2>> neighbours(outline_.points.size(), {kNoPoint, kNoPoint});
    const auto join = [&](uint32_t a, uint32_t b) {
      (neighbours[a][0] == kNoPoint ? neighbours[a][0] : neighbours[a][1]) = b;
    };
    for (const Outline::Line& line : outline_.lines) {
      join(line.from, line.to);
      join(line.to, line.from);
    }
    for (int i = 0; i < kSmoothings; ++i) {
      const std::vector<Vec2> before = outline_.points;
      for (size_t p = 0; p < before.size(); ++p) {
        const auto [a, b] = neighbours[p];
        if (b == kNoPoint) continue;  // an end at the edge of the grid
        outline_.points[p] = 0.25f * (before[a] + before[b]) + 0.5f * before[p];
      }
    }
    return std::move(outline_);
  }

 private:
  /// Returns the point on a side of the square from the centre of the cell (x, y).
  uint32_t point(int x, int y, int side) {
    const bool is_below = side == 1 || side == 3;  // between a cell and the one below it
    if (side == 1) ++x;
    if (side == 2) ++y;
    const size_t cell = static_cast<size_t>(y) * grid_.columns + x;
    uint32_t& index = is_below ? below_[cell] : right_[cell];
    if (index == kNoPoint) {
      index = static_cast<uint32_t>(outline_.points.size());
      const Vec2 half(is_below ? 0.f : 0.5f, is_below ? 0.5f : 0.f);
      outline_.points.push_back(grid_.centre(x, y) + grid_.cell * half);
    }
    return index;
  }

  const CellGrid grid_;
  /// Points between a cell and the next one to the right, and the one below it.
  std::vector<uint32_t> right_, below_;
  Outline outline_;
};

}  // namespace

CellGrid grid_around(const Aabb& bounds, const Sensor& sensor, const Rect& crop, float cell) {
  Vec2 low(crop.x0, crop.y0), high(crop.x1, crop.y1);
  Vec2 first(kInfinity), last(-kInfinity);
  bool is_seen = !bounds.empty();
  for (unsigned i = 0; i < 8 && is_seen; ++i) {
    const auto seen = sensor.connect(bounds.corner(i), Vec2(0.5f));
    is_seen = seen.has_value();
    if (!is_seen) break;
    first = glm::min(first, seen->film_position);
    last = glm::max(last, seen->film_position);
  }
  if (is_seen) {
    low = glm::max(low, glm::floor(first - 2 * cell));
    high = glm::min(high, glm::ceil(last + 2 * cell));
  }
  CellGrid grid{low, cell, 0, 0};
  const Vec2 size = glm::max((high - low) / cell, 0.f);
  grid.columns = static_cast<int>(std::ceil(size.x));
  grid.rows = static_cast<int>(std::ceil(size.y));
  return grid;
}

Outline outline_of(const std::vector<bool>& is_inside, const CellGrid& grid) {
  Contour contour(grid);
  const auto inside = [&](int x, int y) {
    return is_inside[static_cast<size_t>(y) * grid.columns + x] ? 1u : 0u;
  };
  for (int y = 0; y + 1 < grid.rows; ++y) {
    for (int x = 0; x + 1 < grid.columns; ++x) {
      contour.add(x, y, inside(x, y) | inside(x + 1, y) << 1 | inside(x + 1, y + 1) << 2 |
                            inside(x, y + 1) << 3);
    }
  }
  return contour.smoothed();
}

}  // namespace kinome::viewer

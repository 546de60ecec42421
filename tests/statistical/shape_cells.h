#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "kinome/math.h"

/// Histograms over shapes.
namespace kinome::test {

/// Returns the index of x among n equal parts of [0, 1).
inline int part(double x, int n) {
  return std::clamp(static_cast<int>(x * n), 0, n - 1);
}
/// Returns the azimuth of (x, y) as a fraction of a full turn, in [0, 1].
inline double turn(double x, double y) {
  return std::atan2(y, x) / (2 * std::numbers::pi) + 0.5;
}

/// Cells of equal area on an untransformed shape.
struct ShapeCells {
  int count;
  std::function<int(const Vec3& p)> cell;
};

inline const std::map<std::string, ShapeCells>& shape_cells() {
  static const std::map<std::string, ShapeCells> all = {
      {"sphere",
       {8 * 16,
        [](const Vec3& p) { return part((p.z + 1) / 2, 8) * 16 + part(turn(p.x, p.y), 16); }}},
      {"disk",
       {6 * 16,
        [](const Vec3& p) {
          return part(p.x * p.x + p.y * p.y, 6) * 16 + part(turn(p.x, p.y), 16);
        }}},
      {"rectangle",
       {8 * 8, [](const Vec3& p) { return part((p.x + 1) / 2, 8) * 8 + part((p.y + 1) / 2, 8); }}},
      {"cylinder",
       {8 * 16, [](const Vec3& p) { return part(p.z, 8) * 16 + part(turn(p.x, p.y), 16); }}},
      {"cube",
       {6 * 16,
        [](const Vec3& p) {
          int axis = 0;
          for (int i = 1; i < 3; ++i) {
            if (std::abs(p[i]) > std::abs(p[axis])) axis = i;
          }
          const int face = 2 * axis + (p[axis] > 0);
          return (face * 4 + part((p[(axis + 1) % 3] + 1) / 2, 4)) * 4 +
                 part((p[(axis + 2) % 3] + 1) / 2, 4);
        }}},
  };
  return all;
}

}  // namespace kinome::test

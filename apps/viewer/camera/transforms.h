#pragma once

#include <algorithm>

#include "kinome/math.h"

namespace kinome::viewer {

/// Returns true if two transforms are equal up to the rounding of numbers in a scene file.
inline bool are_alike(const Mat4& a, const Mat4& b) {
  for (int column = 0; column < 4; ++column) {
    const Vec3 x(a[column]), y(b[column]);
    if (!(glm::length(x - y) <= 1e-4f * std::max(1e-20f, glm::length(x)))) return false;
  }
  return true;
}

}  // namespace kinome::viewer

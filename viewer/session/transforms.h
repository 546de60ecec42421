#pragma once

#include <algorithm>

#include "kinome/math.h"

namespace kinome::viewer {

/// Whether two transforms are the same but for what a scene file's numbers leave of one.
inline bool are_alike(const Mat4& a, const Mat4& b) {
  for (int column = 0; column < 4; ++column) {
    const Vec3 x(a[column]), y(b[column]);
    if (!(glm::length(x - y) <= 1e-4f * std::max(1e-20f, glm::length(x)))) return false;
  }
  return true;
}

}  // namespace kinome::viewer

#pragma once

#include "kinome/math.h"
#include "kinome/wide/vectors.h"

namespace kinome {

using namespace wide::formulas;

/// Maps surface coordinates to texture coordinates, like Transform::point of (u, v, 0). Requires an
/// affine map, which all transforms of scenes are.
template <class F>
Vec2Of<F> texture_coordinates(const Transform& to_uv, const Vec2Of<F>& uv) {
  const Mat4& m = to_uv.matrix();
  const auto row = [&](int i) { return (m[0][i] * uv.x + m[1][i] * uv.y) + m[3][i]; };
  return {row(0), row(1)};
}

}  // namespace kinome

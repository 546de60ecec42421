#pragma once

#include "kinome/math.h"
#include "kinome/wide/vectors.h"

namespace kinome {

using namespace wide::formulas;

/// Texture coordinates of surface coordinates: what Transform::point makes of (u, v, 0), for an
/// affine map, as all are that scenes have.
template <class F>
Vec2Of<F> texture_coordinates(const Transform& to_uv, const Vec2Of<F>& uv) {
  const Mat4& m = to_uv.matrix();
  const auto row = [&](int i) { return (m[0][i] * uv.x + m[1][i] * uv.y) + m[3][i]; };
  return {row(0), row(1)};
}

}  // namespace kinome

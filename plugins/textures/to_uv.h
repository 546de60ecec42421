#pragma once

#include "kinome/math.h"
#include "kinome/wide/vectors.h"

namespace kinome {

using namespace wide::formulas;

/// Texture coordinates of surface coordinates: what Transform::point makes of (u, v, 0).
template <class F>
Vec2Of<F> texture_coordinates(const Transform& to_uv, const Vec2Of<F>& uv) {
  const Mat4& m = to_uv.matrix();
  const auto row = [&](int i) { return (m[0][i] * uv.x + m[1][i] * uv.y) + m[3][i]; };
  const bool is_affine = m[0][3] == 0 && m[1][3] == 0 && m[3][3] == 1;
  if (is_affine) return {row(0), row(1)};
  const F w = row(3);
  return {row(0) / w, row(1) / w};
}

}  // namespace kinome

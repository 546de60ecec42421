#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "kinome/math.h"
#include "kinome/shape.h"

namespace kinome {

/// Of any shape and ray, from the origin: Embree takes no coordinates beyond 1.8e18.
inline constexpr float kFarthest = 1e18f;

/// True for meshes without faces, for merges and instances of nothing, and for shapes that consist
/// only of such shapes. They take no part in a scene.
inline bool has_no_surface(const Shape& shape) {
  if (const TriangleMesh* const mesh = shape.mesh()) return mesh->triangles.empty();
  const auto parts = shape.parts();
  if (parts.empty()) {
    const Aabb box = shape.bounds(), nothing;
    return box.lo == nothing.lo && box.hi == nothing.hi;
  }
  return std::all_of(parts.begin(), parts.end(),
                     [](const auto& part) { return has_no_surface(*part); });
}

/// What a shape of these bounds does that the ray tracer can't cope with; "": nothing.
inline std::string why_untraceable(const Aabb& box) {
  if (box.empty() || !is_finite(box.lo) || !is_finite(box.hi)) return "has no finite bounds";
  if (!(max_component(glm::max(glm::abs(box.lo), glm::abs(box.hi))) <= kFarthest)) {
    return "reaches beyond 1e18 units, which is too far for the ray tracer";
  }
  return "";
}

/// True if Embree can invert an instance's transform, which it does in single precision by the
/// adjugate over the determinant.
inline bool is_invertible_by_tracer(const Mat4& to_world) {
  const glm::dmat3 linear(to_world);
  const double determinant = std::abs(glm::determinant(linear));
  const auto is_ordinary = [](double x) { return x >= 1e-37 && x <= 1e37; };
  if (!is_ordinary(determinant)) return false;
  const glm::dmat3 inverse = glm::inverse(linear);
  for (int row = 0; row < 3; ++row) {
    const double largest = std::max(
        {std::abs(inverse[0][row]), std::abs(inverse[1][row]), std::abs(inverse[2][row])});
    if (!is_ordinary(largest * determinant)) return false;
  }
  return true;
}

/// The largest component that origin and direction of a ray may have, so that in the space of an
/// instance they stay within kFarthest. An instance that is scaled far down is met, in its own
/// space, by rays from far away.
inline float farthest_ray(const Mat4& to_world) {
  const glm::dmat4 inverse = glm::inverse(glm::dmat4(to_world));
  double farthest = double{kFarthest};
  for (int row = 0; row < 3; ++row) {
    const double stretch =
        std::abs(inverse[0][row]) + std::abs(inverse[1][row]) + std::abs(inverse[2][row]);
    const double left = double{kFarthest} - std::abs(inverse[3][row]);
    farthest = std::min(farthest, std::max(left, 0.) / stretch);
  }
  return static_cast<float>(farthest);
}

}  // namespace kinome

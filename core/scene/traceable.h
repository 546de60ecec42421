#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kinome/math.h"
#include "kinome/shape.h"
#include "kinome/shape_group.h"

namespace kinome {

/// Largest absolute coordinate of shapes and rays. Embree supports coordinates up to 1.8e18.
inline constexpr float kMaxCoordinate = 1e18f;

/// Returns true for meshes without faces, empty merges and instances, and shapes that consist only
/// of such shapes. Scenes ignore them.
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

/// Returns why the ray tracer doesn't support a shape with these bounds, or "" if it does.
inline std::string why_untraceable(const Aabb& box) {
  if (box.empty() || !is_finite(box.lo) || !is_finite(box.hi)) return "has no finite bounds";
  if (!(max_component(glm::max(glm::abs(box.lo), glm::abs(box.hi))) <= kMaxCoordinate)) {
    return "extends beyond 1e18 units, which the ray tracer doesn't support";
  }
  return "";
}

/// Returns true if Embree can invert an instance's transform. Embree divides the adjugate by the
/// determinant in single precision, so neither may overflow or underflow.
inline bool is_invertible_by_tracer(const Mat4& to_world) {
  const glm::dmat3 linear(to_world);
  const double determinant = std::abs(glm::determinant(linear));
  const auto is_normal_number = [](double x) { return x >= 1e-37 && x <= 1e37; };
  if (!is_normal_number(determinant)) return false;
  const glm::dmat3 inverse = glm::inverse(linear);
  for (int row = 0; row < 3; ++row) {
    const double largest = std::max(
        {std::abs(inverse[0][row]), std::abs(inverse[1][row]), std::abs(inverse[2][row])});
    if (!is_normal_number(largest * determinant)) return false;
  }
  return true;
}

/// Returns the largest absolute component that a ray's origin and direction may have in world
/// space. Within this limit, their components in the instance's local space are at most
/// kMaxCoordinate. The limit matters for strongly scaled-down instances, because the transform to
/// their local space enlarges coordinates.
inline float max_ray_coordinate(const Mat4& to_world) {
  const glm::dmat4 inverse = glm::inverse(glm::dmat4(to_world));
  double max_coordinate = double{kMaxCoordinate};
  for (int row = 0; row < 3; ++row) {
    const double stretch =
        std::abs(inverse[0][row]) + std::abs(inverse[1][row]) + std::abs(inverse[2][row]);
    const double left = double{kMaxCoordinate} - std::abs(inverse[3][row]);
    max_coordinate = std::min(max_coordinate, std::max(left, 0.) / stretch);
  }
  return static_cast<float>(max_coordinate);
}
/// Returns the same for all instances of a scene.
inline float max_ray_coordinate(const std::vector<const ShapeInstance*>& instances) {
  float max_coordinate = kMaxCoordinate;
  for (const ShapeInstance* const instance : instances) {
    max_coordinate = std::min(max_coordinate, max_ray_coordinate(instance->to_world()));
  }
  return max_coordinate;
}

}  // namespace kinome

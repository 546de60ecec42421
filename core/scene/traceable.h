#pragma once

#include <algorithm>
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

}  // namespace kinome

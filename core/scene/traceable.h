#pragma once

#include <string>

#include "kinome/math.h"

namespace kinome {

/// Of any shape and ray, from the origin: Embree takes no coordinates beyond 1.8e18.
inline constexpr float kFarthest = 1e18f;

/// What a shape of these bounds does that the ray tracer can't cope with; "": nothing.
inline std::string why_untraceable(const Aabb& box) {
  if (box.empty() || !is_finite(box.lo) || !is_finite(box.hi)) return "has no finite bounds";
  if (!(max_component(glm::max(glm::abs(box.lo), glm::abs(box.hi))) <= kFarthest)) {
    return "reaches beyond 1e18 units, which is too far for the ray tracer";
  }
  return "";
}

}  // namespace kinome

#pragma once

#include <optional>

#include "kinome/export.h"
#include "kinome/math.h"

namespace kinome {

/// The place of a camera at `origin`, as <lookat> gives it: it looks along +z of the result, +x is
/// left, +y up. nullopt where `up`, of any length, is parallel to the viewing direction. `origin`
/// and `target` must not be the same point.
KINOME_EXPORT std::optional<glm::dmat4> look_at(const Vec3& origin, const Vec3& target,
                                                const Vec3& up);

/// Of the six directions along an axis of the world the one that `up` is nearest to: a camera that
/// looks up or down a little has an `up` of its own that is no more the scene's.
inline Vec3 nearest_axis(const Vec3& up) {
  const Vec3 size = glm::abs(up);
  const int i = size.y >= size.x && size.y >= size.z ? 1 : size.x >= size.z ? 0 : 2;
  Vec3 axis(0.f);
  axis[i] = up[i] < 0 ? -1.f : 1.f;
  return axis;
}

}  // namespace kinome

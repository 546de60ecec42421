#pragma once

#include <optional>

#include "kinome/export.h"
#include "kinome/math.h"

namespace kinome {

/// Returns the camera-to-world matrix of <lookat>: a camera at `origin` that looks along its +z
/// axis, with +x to the left and +y up. Returns nullopt if `up` (of any length) is parallel to the
/// viewing direction. `origin` and `target` must differ.
KINOME_EXPORT std::optional<glm::dmat4> look_at(const Vec3& origin, const Vec3& target,
                                                const Vec3& up);

/// Returns the world axis direction nearest to `up`. It recovers the scene's up direction from that
/// of a slightly tilted camera.
inline Vec3 nearest_axis(const Vec3& up) {
  const Vec3 size = glm::abs(up);
  const int i = size.y >= size.x && size.y >= size.z ? 1 : size.x >= size.z ? 0 : 2;
  Vec3 axis(0.f);
  axis[i] = up[i] < 0 ? -1.f : 1.f;
  return axis;
}

}  // namespace kinome

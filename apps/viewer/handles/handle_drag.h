#pragma once

#include <optional>

#include "kinome/math.h"
#include "kinome/ray.h"

namespace kinome::viewer {

/// Part of the handles of an object that the user can drag. The axes are those of the world.
enum class Handle {
  kMoveX,   ///< along an axis
  kMoveY,
  kMoveZ,
  kMoveYZ,  ///< in the plane perpendicular to an axis
  kMoveZX,
  kMoveXY,
  kMoveInView,  ///< in the plane perpendicular to the viewing direction
  kTurnX,       ///< around an axis
  kTurnY,
  kTurnZ
};
inline constexpr int kNumHandles = 10;

/// Returns the axis of a handle: 0 for x, 1 for y, 2 for z; for a plane, that of its normal. -1 for
/// kMoveInView.
inline int axis_of(Handle handle) {
  return handle == Handle::kMoveInView ? -1
         : handle > Handle::kMoveInView ? static_cast<int>(handle) - 7
                                        : static_cast<int>(handle) % 3;
}

/// Returns the world-space transform of a drag from the ray `from` to the ray `to`, which are
/// camera rays through the mouse. `pivot` is the position of the handles at the start, and the
/// centre of rotations. `forward` is the viewing direction, a unit vector. Returns nullopt if a ray
/// misses the handle's plane, or is almost parallel to it.
std::optional<Mat4> dragged(Handle handle, const Vec3& pivot, const Vec3& forward, const Ray& from,
                            const Ray& to);

}  // namespace kinome::viewer

#pragma once

#include "kinome/image.h"

namespace kinome::viewer {

/// Position of the viewer of a sphere of directions, in radians. At 0, 0 the viewer is at +Z, with
/// +Y up.
struct Orbit {
  float yaw = 0;    ///< toward +X
  float pitch = 0;  ///< in [-pi/2, pi/2]; positive: from above
};

/// Returns the direction at a position in the sphere's image, with x and y from -1 to 1 (y down).
/// The sphere is seen from outside by a parallel projection. Off the sphere, the result has z = 2.
Vec3 sphere_direction(const Orbit& orbit, float x, float y);

/// Wraps a map of all directions around a sphere. The result has `size` x `size` pixels, the
/// channels R, G, B, and this background. Ignores rows of `map` below drawing::kMapHeight, such as
/// a legend. See drawing::map_position().
Image sphere_picture(const Image& map, const Orbit& orbit, int size, float background);

}  // namespace kinome::viewer

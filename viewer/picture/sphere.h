#pragma once

#include "kinome/image.h"

namespace kinome::viewer {

/// From where a sphere of directions is looked at, in radians: 0, 0 is from +Z, with +Y up.
struct Orbit {
  float yaw = 0;    ///< toward +X
  float pitch = 0;  ///< in [-pi/2, pi/2]; positive: from above
};

/// The direction at a place of the sphere's picture, x and y from -1 to 1 (y down), as seen from
/// outside by a parallel projection; z of the result is 2 where the place is off the sphere.
Vec3 sphere_direction(const Orbit& orbit, float x, float y);

/// A map of all directions (see drawing::map_direction; rows below its lower half, such as a
/// legend, are none of it), wrapped around a sphere: `size` pixels square, R, G, B, over
/// `background`.
Image sphere_picture(const Image& map, const Orbit& orbit, int size, float background);

}  // namespace kinome::viewer

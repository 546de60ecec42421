#include "picture/sphere.h"

#include <algorithm>
#include <cmath>

#include "drawing/inspection_image.h"

namespace kinome::viewer {

Vec3 sphere_direction(const Orbit& orbit, float x, float y) {
  const float z2 = 1 - x * x - y * y;
  if (z2 < 0) return {0, 0, 2};
  const Vec3 toward(std::sin(orbit.yaw) * std::cos(orbit.pitch), std::sin(orbit.pitch),
                    std::cos(orbit.yaw) * std::cos(orbit.pitch));
  const Vec3 right(std::cos(orbit.yaw), 0, -std::sin(orbit.yaw));
  return x * right - y * glm::cross(toward, right) + std::sqrt(z2) * toward;
}

Image sphere_picture(const Image& map, const Orbit& orbit, int size, float background) {
  Image picture{size, size, {"R", "G", "B"}, {}};
  picture.data.assign(static_cast<size_t>(size) * size * 3, background);
  const auto place = [&](int i) { return 2 * (static_cast<float>(i) + 0.5f) / size - 1; };
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Vec3 d = sphere_direction(orbit, place(x), place(y));
      if (d.z > 1.5f) continue;
      const Vec2 at = drawing::map_position(d);
      const int column = std::min(static_cast<int>(at.x), drawing::kMapWidth - 1);
      const int row = std::min(static_cast<int>(at.y), drawing::kMapHeight - 1);
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = map.at(column, row, c);
    }
  }
  return picture;
}

}  // namespace kinome::viewer

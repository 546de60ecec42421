#include "kinome/look_at.h"

namespace kinome {

std::optional<glm::dmat4> look_at(const Vec3& origin, const Vec3& target, const Vec3& up) {
  using glm::dvec3;
  const dvec3 direction = glm::normalize(dvec3(target) - dvec3(origin));
  const dvec3 left = glm::cross(glm::normalize(dvec3(up)), direction);
  if (!(glm::length(left) > 1e-6)) return std::nullopt;
  const dvec3 unit_left = glm::normalize(left);
  glm::dmat4 m(1);
  m[0] = glm::dvec4(unit_left, 0);
  m[1] = glm::dvec4(glm::cross(direction, unit_left), 0);
  m[2] = glm::dvec4(direction, 0);
  m[3] = glm::dvec4(origin, 1);
  return m;
}

}  // namespace kinome

#include "kinome/look_at.h"

namespace kinome {

std::optional<glm::dmat4> look_at(const glm::dvec3& origin, const glm::dvec3& target,
                                  const glm::dvec3& up) {
  const glm::dvec3 direction = glm::normalize(target - origin);
  const glm::dvec3 left = glm::cross(glm::normalize(up), direction);
  if (!(glm::length(left) > 1e-6)) return std::nullopt;
  const glm::dvec3 unit_left = glm::normalize(left);
  glm::dmat4 m(1);
  m[0] = glm::dvec4(unit_left, 0);
  m[1] = glm::dvec4(glm::cross(direction, unit_left), 0);
  m[2] = glm::dvec4(direction, 0);
  m[3] = glm::dvec4(origin, 1);
  return m;
}

}  // namespace kinome

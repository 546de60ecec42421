#include "kinome/math.h"

namespace kinome {

Transform::Transform(const Mat4& m) : m_(m), inverse_(glm::inverse(glm::dmat4(m))) {}

bool Transform::is_invertible() const {
  const double determinant = glm::determinant(glm::dmat4(m_));
  if (!std::isfinite(determinant) || determinant == 0) return false;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(inverse_[column][row])) return false;
    }
  }
  return true;
}

bool Transform::has_scale() const {
  // The linear part preserves lengths if and only if its columns are orthonormal.
  const glm::mat3 linear(m_);
  const glm::mat3 difference = glm::transpose(linear) * linear - glm::mat3(1.f);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(difference[column][row]) <= 1e-3f)) return true;
    }
  }
  return false;
}

bool Transform::flips_handedness() const {
  return glm::determinant(glm::dmat3(glm::dmat4(m_))) < 0;
}

Vec3 Transform::point(const Vec3& p) const {
  const glm::vec4 q = m_ * glm::vec4(p, 1.f);
  return q.w == 1.f ? Vec3(q) : Vec3(q) / q.w;
}

Vec3 Transform::vector(const Vec3& v) const {
  return Vec3(m_ * glm::vec4(v, 0.f));
}

Vec3 Transform::normal(const Vec3& n) const {
  // Multiplies by the inverse transpose: n is a row vector.
  return Vec3(glm::vec4(n, 0.f) * inverse_);
}

Transform Transform::inverse() const {
  return Transform(inverse_, m_);
}

}  // namespace kinome

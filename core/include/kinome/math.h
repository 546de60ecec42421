#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include <glm/glm.hpp>

#include "kinome/export.h"

namespace kinome {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Mat4 = glm::mat4;

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// The largest float below 1: the upper end of every random number.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

inline float sqr(float x) {
  return x * x;
}
/// Square root that takes rounding below zero as zero.
inline float safe_sqrt(float x) {
  return std::sqrt(std::max(x, 0.f));
}
inline float max_component(const Vec3& v) {
  return std::max({v.x, v.y, v.z});
}
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Orthonormal basis; n is the third axis, as in every shading frame.
struct Frame {
  Vec3 s{1, 0, 0};
  Vec3 t{0, 1, 0};
  Vec3 n{0, 0, 1};

  /// Any right-handed frame around the unit vector n (Duff et al. 2017).
  static Frame from_normal(const Vec3& n) {
    const float sign = std::copysign(1.f, n.z);
    const float a = -1.f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {
        {1.f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  /// Frame whose s follows dp_du as far as n allows (Mitsuba's convention); any frame if it can't.
  static Frame from_normal_and_tangent(const Vec3& n, const Vec3& dp_du) {
    const Vec3 s = dp_du - n * glm::dot(n, dp_du);
    const float length2 = glm::dot(s, s);
    if (!(length2 > 1e-12f * glm::dot(dp_du, dp_du)) || !std::isfinite(length2)) {
      return from_normal(n);
    }
    const Vec3 unit = s / std::sqrt(length2);
    return {unit, glm::cross(n, unit), n};
  }
  Vec3 to_local(const Vec3& v) const { return {glm::dot(v, s), glm::dot(v, t), glm::dot(v, n)}; }
  Vec3 to_world(const Vec3& v) const { return s * v.x + t * v.y + n * v.z; }
};

/// Affine or projective map with its inverse.
class KINOME_EXPORT Transform {
 public:
  Transform() = default;
  /// Inverts m in double precision. The caller checks is_invertible() where users supply m.
  explicit Transform(const Mat4& m);

  const Mat4& matrix() const { return m_; }
  const Mat4& inverse_matrix() const { return inverse_; }
  bool is_invertible() const;
  bool is_identity() const { return m_ == Mat4(1.f); }
  /// True where the linear part stretches any axis by more than about 1e-3.
  bool has_scale() const;
  /// True where the linear part mirrors (negative determinant).
  bool flips_handedness() const;

  Vec3 point(const Vec3& p) const;   ///< with the projective division
  Vec3 vector(const Vec3& v) const;  ///< linear part
  Vec3 normal(const Vec3& n) const;  ///< inverse transpose; not normalised
  Transform inverse() const;
  /// First b, then a.
  friend Transform operator*(const Transform& a, const Transform& b) {
    return Transform(a.m_ * b.m_, b.inverse_ * a.inverse_);
  }

 private:
  Transform(const Mat4& m, const Mat4& inverse) : m_(m), inverse_(inverse) {}
  Mat4 m_{1.f};
  Mat4 inverse_{1.f};
};

/// Axis-aligned box; default-constructed empty (lo > hi).
struct Aabb {
  Vec3 lo{kInfinity};
  Vec3 hi{-kInfinity};

  bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  void expand(const Vec3& p) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  void expand(const Aabb& b) {
    lo = glm::min(lo, b.lo);
    hi = glm::max(hi, b.hi);
  }
  Vec3 centre() const { return 0.5f * (lo + hi); }
  Vec3 extent() const { return hi - lo; }
  Vec3 corner(unsigned i) const {
    return {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
  }
};

/// Pixels [x0, x1) x [y0, y1).
struct Rect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  int area() const { return width() * height(); }
};

}  // namespace kinome

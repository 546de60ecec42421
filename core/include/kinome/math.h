#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

#include <glm/glm.hpp>

#include "kinome/export.h"

namespace kinome {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Mat4 = glm::mat4;

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Largest float below 1: the upper bound of random numbers.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

inline float sqr(float x) {
  return x * x;
}
/// Square root that treats negative values from rounding as 0.
inline float safe_sqrt(float x) {
  return std::sqrt(std::max(x, 0.f));
}
inline float max_component(const Vec3& v) {
  return std::max({v.x, v.y, v.z});
}
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Scalar versions of functions in kinome/wide, for formulas that are templates over both.
namespace plain {
template <class T>
T select(bool m, const T& a, const std::type_identity_t<T>& b) {
  return m ? a : b;
}
inline bool all(bool m) {
  return m;
}
}  // namespace plain

/// Orthonormal basis with the normal n as third axis, as in all shading frames. V is Vec3 or
/// wide::Vec3.
template <class V>
struct FrameOf {
  using F = std::remove_cvref_t<decltype(V().x)>;
  V s{1.f, 0.f, 0.f};
  V t{0.f, 1.f, 0.f};
  V n{0.f, 0.f, 1.f};

  FrameOf() = default;
  /// Takes right-handed orthonormal axes. To build a frame from a normal, use from_normal().
  FrameOf(const V& s_axis, const V& t_axis, const V& n_axis) : s(s_axis), t(t_axis), n(n_axis) {}

  /// Returns a right-handed frame around the unit vector n (Duff et al. 2017).
  static FrameOf from_normal(const V& n) {
    using std::copysign;
    const F sign = copysign(F(1.f), n.z);
    const F a = -1.f / (sign + n.z);
    const F b = n.x * n.y * a;
    return {
        {1.f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
  /// Returns the frame whose s is dp_du projected onto the plane of n (Mitsuba's convention), or
  /// any frame around n if that is degenerate.
  static FrameOf from_normal_and_tangent(const V& n, const V& dp_du) {
    using plain::all, plain::select, std::sqrt;
    const V along = dp_du - n * dot(n, dp_du);
    const F length2 = dot(along, along);
    const auto usable = length2 > 1e-12f * dot(dp_du, dp_du) && length2 < kInfinity;
    const V unit = along / sqrt(length2);
    const FrameOf frame{unit, cross(n, unit), n};
    if (all(usable)) return frame;
    const FrameOf any = from_normal(n);
    return {select(usable, frame.s, any.s), select(usable, frame.t, any.t), n};
  }
  V to_local(const V& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
  V to_world(const V& v) const { return s * v.x + t * v.y + n * v.z; }
};
using Frame = FrameOf<Vec3>;

/// Affine or projective transform with its inverse.
class KINOME_EXPORT Transform {
 public:
  Transform() = default;
  /// Inverts m in double precision. For matrices from users, check is_invertible().
  explicit Transform(const Mat4& m);

  const Mat4& matrix() const { return m_; }
  const Mat4& inverse_matrix() const { return inverse_; }
  bool is_invertible() const;
  bool is_identity() const { return m_ == Mat4(1.f); }
  /// True if the linear part scales some axis by more than about 1e-3.
  bool has_scale() const;
  /// True if the linear part mirrors (negative determinant).
  bool flips_handedness() const;

  Vec3 point(const Vec3& p) const;   ///< transforms a point, with the perspective division
  Vec3 vector(const Vec3& v) const;  ///< transforms a vector by the linear part
  Vec3 normal(const Vec3& n) const;  ///< transforms a normal by the inverse transpose; not
                                     ///< normalised
  Transform inverse() const;
  /// Composition that applies b first, then a.
  friend Transform operator*(const Transform& a, const Transform& b) {
    return Transform(a.m_ * b.m_, b.inverse_ * a.inverse_);
  }

 private:
  Transform(const Mat4& m, const Mat4& inverse) : m_(m), inverse_(inverse) {}
  Mat4 m_{1.f};
  Mat4 inverse_{1.f};
};

/// Axis-aligned bounding box; empty by default (lo > hi).
struct Aabb {
  Vec3 lo{kInfinity};
  Vec3 hi{-kInfinity};

  Aabb() = default;
  Aabb(const Vec3& lower, const Vec3& upper) : lo(lower), hi(upper) {}

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

/// Rectangle of pixels [x0, x1) x [y0, y1).
struct Rect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  Rect() = default;
  Rect(int left, int top, int right, int bottom) : x0(left), y0(top), x1(right), y1(bottom) {}

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  int area() const { return width() * height(); }
};

}  // namespace kinome

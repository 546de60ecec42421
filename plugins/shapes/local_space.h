#pragma once

#include <cmath>
#include <numbers>

#include "kinome/math.h"
#include "kinome/ray.h"
#include "kinome/wide/doubles.h"
#include "kinome/wide/surface_point.h"

namespace kinome {

using DVec3 = glm::dvec3;
using namespace wide::formulas;

/// A ray in double precision. D is double or wide::Double.
template <class D>
struct LocalLine {
  DVecOf<D> o, d;
};

/// Local space of an analytic shape, and its transform to world space, in double precision. Rays,
/// centres and matrices are floats, so the shape is exact. The error of a hit is far below a
/// float's resolution, also for a sphere of radius 1e6 or a disk at 1e5.
class LocalSpace {
 public:
  explicit LocalSpace(const glm::dmat4& to_world)
      : linear_(to_world), offset_(to_world[3]), inverse_(glm::inverse(glm::dmat3(to_world))) {}

  /// o and d have single precision.
  template <class V>
  auto to_local(const V& o, const V& d) const {
    return LocalLine<DoubleOf<NumberOf<V>>>{inverse_ * from_offset(o), inverse_ * to_double(d)};
  }
  /// Returns the vector in world space from the origin of the local space to a point p of single
  /// precision.
  template <class V>
  auto from_offset(const V& p) const {
    const auto exact = to_double(p);
    return exact - decltype(to_double(p))(offset_);
  }
  template <class V>
  V point_to_world(const V& p) const {
    return linear_ * p + V(offset_);
  }
  template <class V>
  V vector_to_world(const V& v) const {
    return linear_ * v;
  }
  /// Returns a unit vector.
  template <class V>
  V normal_to_world(const V& n) const {
    return normalize(n * inverse_);
  }
  const glm::dmat3& linear() const { return linear_; }
  const DVec3& offset() const { return offset_; }

 private:
  glm::dmat3 linear_;
  DVec3 offset_;
  glm::dmat3 inverse_;
};

/// Returns a bound on the distance from the surface for a point that is exact except for rounding
/// to float, and for a ray origin offset from it. Each coordinate is rounded twice, with a relative
/// error of at most u = 2^-24, which gives 2 sqrt(3) u M < 4 u M; this is doubled. `extent`, the
/// largest coordinate of the shape or its centre, bounds the error of double arithmetic, in case p
/// is near the origin but the shape isn't.
template <class V>
NumberOf<V> surface_error(const V& p, double extent) {
  return 8 * 0x1p-24f * max_component(abs(p)) + static_cast<float>(1e-13 * extent);
}

/// Parameters where a line intersects a quadric; t0 <= t1 if they exist.
template <class D>
struct Roots {
  D t0, t1;
  MaskOf<D> exist;
};

/// Returns the first root in [tmin, tmax] for which `accept` is true, as float; infinity if there
/// is none.
template <class D, class Accept>
FloatOf<D> first_root(const Roots<D>& roots, FloatOf<D> tmin, FloatOf<D> tmax,
                      const Accept& accept) {
  const auto is_hit = [&](D root) {
    return roots.exist && root >= to_double(tmin) && to_float(root) <= tmax && accept(root);
  };
  const FloatOf<D> far = select(is_hit(roots.t1), to_float(roots.t1), FloatOf<D>(kInfinity));
  return select(is_hit(roots.t0), to_float(roots.t0), far);
}

/// Solves |o + t d|² = 1 over the first `dimensions` coordinates. The discriminant is computed from
/// the line's nearest point to the centre, which avoids cancellation for distant origins (Haines et
/// al. 2019).
template <int dimensions, class D>
Roots<D> unit_ball_roots(const LocalLine<D>& line) {
  auto o = line.o, d = line.d;
  if constexpr (dimensions == 2) o.z = d.z = D(0.0);
  const D inverse = 1.0 / dot(d, d);
  const D middle = -(dot(o, d) * inverse);
  const auto nearest = o + d * middle;
  const D discriminant = (1.0 - dot(nearest, nearest)) * inverse;
  // For an origin on the surface, the difference below cancels, but the error is far below a
  // float's resolution.
  const D half = sqrt(discriminant);
  return {middle - half, middle + half, discriminant >= 0.0};
}

/// Returns the angle of (x, y) as a fraction of a turn in [0, 1], counterclockwise from +x.
template <class D>
FloatOf<D> turn(D x, D y) {
  const D phi = atan2(y, x) / (2 * std::numbers::pi);
  return to_float(select(phi < 0.0, phi + 1.0, phi));
}

/// True if the columns of the linear part are orthogonal and the first `columns` have the same
/// length, to the accuracy of float.
inline bool is_similarity(const glm::dmat3& m, int columns = 3) {
  const double length2 = glm::dot(m[0], m[0]);
  for (int i = 0; i < columns; ++i) {
    if (std::abs(glm::dot(m[i], m[i]) - length2) > 1e-4 * length2) return false;
    for (int j = 0; j < 3; ++j) {
      const double other2 = glm::dot(m[j], m[j]);
      if (i != j && std::abs(glm::dot(m[i], m[j])) > 1e-4 * std::sqrt(length2 * other2)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace kinome

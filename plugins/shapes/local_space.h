#pragma once

#include <cmath>

#include "kinome/math.h"
#include "kinome/ray.h"

namespace kinome {

using DVec3 = glm::dvec3;

struct DoubleRay {
  DVec3 o, d;
};

/// The space of an analytic shape, mapped to world space. In double precision: rays, centres and
/// matrices are floats, so the shape is exact, and a hit is off by far less than a float can tell,
/// also for a sphere of radius 1e6 or a disk at 1e5.
class LocalSpace {
 public:
  explicit LocalSpace(const glm::dmat4& to_world)
      : linear_(to_world), offset_(to_world[3]), inverse_(glm::inverse(glm::dmat3(to_world))) {}

  DoubleRay to_local(const Ray& ray) const {
    return {inverse_ * (DVec3(ray.o) - offset_), inverse_ * DVec3(ray.d)};
  }
  DVec3 point_to_world(const DVec3& p) const { return linear_ * p + offset_; }
  DVec3 vector_to_world(const DVec3& v) const { return linear_ * v; }
  DVec3 vector_to_local(const DVec3& v) const { return inverse_ * v; }
  /// Unit.
  DVec3 normal_to_world(const DVec3& n) const { return glm::normalize(n * inverse_); }
  const glm::dmat3& linear() const { return linear_; }
  const DVec3& offset() const { return offset_; }

 private:
  glm::dmat3 linear_;
  DVec3 offset_;
  glm::dmat3 inverse_;
};

/// Bound on the distance from the surface of a point that is exact but for rounding to float, and
/// of a ray's origin moved from it: each coordinate is rounded twice, by at most u = 2^-24 of
/// itself, which makes 2 sqrt(3) u M < 4 u M; doubled. `extent` (the largest coordinate of shape or
/// centre) covers the double arithmetic, where p lies near the origin but its shape does not.
inline float surface_error(const Vec3& p, double extent) {
  return 8 * 0x1p-24f * max_component(glm::abs(p)) + static_cast<float>(1e-13 * extent);
}

/// The first of t0 <= t1 in [tmin, tmax] that `accept` agrees to, as float; false where none.
template <class Accept>
bool first_root(double t0, double t1, const Ray& ray, float& t, const Accept& accept) {
  for (const double root : {t0, t1}) {
    const auto rounded = static_cast<float>(root);
    if (root >= ray.tmin && rounded <= ray.tmax && accept(root)) {
      t = rounded;
      return true;
    }
  }
  return false;
}

/// Roots of |o + t d|² = 1 over the first `dimensions` coordinates, in order; false where the line
/// misses. The discriminant is taken from the point of the line nearest to the centre, which
/// doesn't cancel where the origin is far away (Haines et al. 2019).
template <int dimensions>
bool unit_ball_roots(const DoubleRay& ray, double& t0, double& t1) {
  glm::vec<dimensions, double> o, d;
  for (int i = 0; i < dimensions; ++i) {
    o[i] = ray.o[i];
    d[i] = ray.d[i];
  }
  const double a = glm::dot(d, d);
  if (!(a > 0)) return false;
  const double b = glm::dot(o, d);
  const auto nearest = o - d * (b / a);
  const double discriminant = a * (1 - glm::dot(nearest, nearest));
  if (!(discriminant >= 0)) return false;
  // |o|² - 1 as a product, so that an origin on the surface keeps its digits.
  const double length = glm::length(o);
  const double c = (length - 1) * (length + 1);
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  t0 = q / a;
  t1 = q != 0 ? c / q : t0;
  if (t0 > t1) std::swap(t0, t1);
  return true;
}

/// The interaction at a point that lies on the shape: as a ray along -n would find it. n is about as
/// long as the shape is wide, so that the ray's origin keeps the point's digits.
template <class AnalyticShape>
SurfaceInteraction interaction_at(const AnalyticShape& shape, const DVec3& p, const DVec3& n) {
  Ray ray;
  ray.o = Vec3(p + n);
  ray.d = Vec3(-n);
  ray.tmax = 1;
  SurfaceInteraction si = shape.interaction(ray, Hit{});
  si.shape = &shape;
  return si;
}

/// uv.x of an angle: 0 to 1, counterclockwise from +x.
inline double turn(double x, double y) {
  const double phi = std::atan2(y, x) / (2 * std::numbers::pi);
  return phi < 0 ? phi + 1 : phi;
}

/// True where the columns of the linear part are orthogonal and of one length, to float's accuracy.
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

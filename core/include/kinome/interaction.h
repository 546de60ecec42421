#pragma once

#include <cmath>

#include "kinome/math.h"
#include "kinome/ray.h"

namespace kinome {

class Shape;

/// The origin of a ray toward d that leaves a surface at p, where its normal is n: `error` off the
/// surface, on the side of d. V is Vec3 or wide::Vec3, F their number.
template <class V, class F>
V origin_off_surface(const V& p, const V& n, const F& error, const V& d) {
  using std::copysign;
  return p + n * copysign(error, dot(n, d));
}

/// A shadow ray, see SurfaceInteraction::shadow_ray; V and F as there.
template <class V, class F>
struct ShadowRayOf {
  V o, d;
  F tmax;

  /// From p as origin_off_surface(); `may_be_near`: not all distances are infinite.
  ShadowRayOf(const V& p, const V& n, const F& error, const V& toward, const F& distance,
              bool may_be_near)
      : o(origin_off_surface(p, n, error, toward)), d(toward), tmax(kInfinity) {
    if (!may_be_near) return;
    using plain::select, std::max;
    const auto near = distance < kInfinity;
    const V to = p + toward * select(near, distance, F(1.f)) - o;
    const F length_to = length(to);
    d = select(near, to / length_to, d);
    tmax = select(near, max(length_to * (1 - 1e-4f) - error, F(0.f)), F(kInfinity));
  }
};

/// A point on a surface, seen along a ray.
struct SurfaceInteraction {
  float t = kInfinity;  ///< distance along the ray, in units of its direction
  Vec3 p{0.f};
  /// Bound on the distance between p and the true surface, world units: rays that leave p start
  /// this far along the normal. Grows with the magnitude of the coordinates, not with the scene.
  float p_error = 0;
  Vec3 n{0, 0, 1};  ///< unit geometric normal; the shape's outside, not necessarily the ray's side
  Frame frame;      ///< shading frame; n interpolated, s along dp_du
  Vec3 dp_du{1, 0, 0};
  Vec3 dp_dv{0, 1, 0};
  Vec2 uv{0.f};
  Vec3 wi{0, 0, 1};  ///< unit, toward where the ray came from, in `frame`
  const Shape* shape = nullptr;
  uint32_t primitive = 0;

  /// Where a ray toward the world direction d starts: p moved off the surface to the side of d.
  Vec3 ray_origin(const Vec3& d) const {
    return origin_off_surface(p, n, p_error, d);
  }
  /// Whether a point at `distance` along the unit vector d is off the surface by more than the
  /// error of p. Of another point of the same curved surface that isn't, it is but rounding that
  /// tells on which side it is, and where.
  bool resolves(const Vec3& d, float distance) const {
    return std::abs(glm::dot(n, d)) * distance > p_error;
  }
  /// Shadow ray toward a light at `distance` (infinite for distant light) along the unit vector d.
  /// It ends shortly before the very point p + distance d, from wherever it starts: else a light
  /// nearer than 10^4 p_error would shadow itself. Shortly is a part of the distance and, for far
  /// from the origin the light's own place is as uncertain as p is, p_error.
  Ray shadow_ray(const Vec3& d, float distance) const {
    const ShadowRayOf<Vec3, float> shadow(p, n, p_error, d, distance, distance < kInfinity);
    Ray ray;
    ray.o = shadow.o;
    ray.d = shadow.d;
    ray.tmax = shadow.tmax;
    return ray;
  }
  /// The same toward the place `to`.
  Ray shadow_ray_to(const Vec3& to) const {
    const float distance = glm::length(to - p);
    return shadow_ray((to - p) / std::max(distance, 1e-30f), distance);
  }
};

}  // namespace kinome

#pragma once

#include <cmath>

#include "kinome/math.h"
#include "kinome/ray.h"

namespace kinome {

class Shape;

/// Returns the origin of a ray that leaves a surface at p with normal n toward d: p moved along n
/// by `error`, to the side of d. V is Vec3 or wide::Vec3, F the matching number type.
template <class V, class F>
V origin_off_surface(const V& p, const V& n, const F& error, const V& d) {
  using std::copysign;
  return p + n * copysign(error, dot(n, d));
}

/// Shadow ray (see SurfaceInteraction::shadow_ray()). V and F are as above.
template <class V, class F>
struct ShadowRayOf {
  V o, d;
  F tmax;

  /// Starts at origin_off_surface(p, n, error, toward). `may_be_finite` is false if all distances
  /// are infinite.
  ShadowRayOf(const V& p, const V& n, const F& error, const V& toward, const F& distance,
              bool may_be_finite)
      : o(origin_off_surface(p, n, error, toward)), d(toward), tmax(kInfinity) {
    if (!may_be_finite) return;
    using plain::select, std::max;
    const auto near = distance < kInfinity;
    const V to = p + toward * select(near, distance, F(1.f)) - o;
    const F length_to = length(to);
    d = select(near, to / length_to, d);
    tmax = select(near, max(length_to * (1 - 1e-4f) - error, F(0.f)), F(kInfinity));
  }
};

/// Surface point seen along a ray.
struct SurfaceInteraction {
  float t = kInfinity;  ///< ray parameter of the hit, in units of the ray's direction
  Vec3 p{0.f};
  /// Bound on the distance between p and the true surface, world units. Rays that leave p start
  /// this far along the normal. It grows with the magnitude of the coordinates, not with the
  /// scene's size.
  float p_error = 0;
  Vec3 n{0, 0, 1};  ///< unit geometric normal, toward the shape's outside
  Frame frame;      ///< shading frame: n interpolated, s along dp_du
  Vec3 dp_du{1, 0, 0};
  Vec3 dp_dv{0, 1, 0};
  Vec2 uv{0.f};
  Vec3 wi{0, 0, 1};  ///< unit, toward the ray's origin, in `frame`
  const Shape* shape = nullptr;
  uint32_t primitive = 0;

  /// Returns `frame` with its normal turned to the side from which the ray comes.
  Frame frame_toward_viewer() const {
    Frame turned = frame;
    if (wi.z < 0) turned.n = -turned.n;
    return turned;
  }
  /// Returns the origin of a ray toward the world direction d: p moved off the surface to the side
  /// of d.
  Vec3 ray_origin(const Vec3& d) const {
    return origin_off_surface(p, n, p_error, d);
  }
  /// Returns the ray that leaves the surface toward the world direction d.
  Ray spawn_ray(const Vec3& d) const { return {ray_origin(d), d}; }
  /// True if the point at `distance` along the unit vector d is farther from the tangent plane than
  /// p_error. Otherwise rounding alone determines on which side another point of the same curved
  /// surface is.
  bool resolves(const Vec3& d, float distance) const {
    return std::abs(glm::dot(n, d)) * distance > p_error;
  }
  /// Returns the shadow ray toward a point at `distance` along the unit vector d; infinite for
  /// distant light. The ray ends slightly before p + distance d. The gap is measured from the ray's
  /// offset origin, because otherwise emitters nearer than 10^4 p_error would occlude themselves.
  /// The gap is relative to the distance, plus p_error, because far from the origin the emitter's
  /// position is as inaccurate as p.
  Ray shadow_ray(const Vec3& d, float distance) const {
    const ShadowRayOf<Vec3, float> shadow(p, n, p_error, d, distance, distance < kInfinity);
    return {shadow.o, shadow.d, 0, shadow.tmax};
  }
  /// Returns the shadow ray toward the point `to`.
  Ray shadow_ray_to(const Vec3& to) const {
    const float distance = glm::length(to - p);
    return shadow_ray((to - p) / std::max(distance, 1e-30f), distance);
  }
};

}  // namespace kinome

#pragma once

#include "kinome/math.h"
#include "kinome/ray.h"

namespace kinome {

class Shape;

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
    return p + n * (glm::dot(n, d) >= 0 ? p_error : -p_error);
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
    Ray ray;
    ray.o = ray_origin(d);
    ray.d = d;
    if (distance < kInfinity) {
      const Vec3 to = p + d * distance - ray.o;
      distance = glm::length(to);
      ray.d = to / distance;
    }
    ray.tmax = distance * (1 - 1e-4f);
    if (distance < kInfinity) ray.tmax = std::max(ray.tmax - p_error, 0.f);
    return ray;
  }
  /// The same toward the place `to`.
  Ray shadow_ray_to(const Vec3& to) const {
    const float distance = glm::length(to - p);
    return shadow_ray((to - p) / std::max(distance, 1e-30f), distance);
  }
};

}  // namespace kinome

#pragma once

#include <functional>

#include "kinome/scene.h"

/// Functions that trace single rays in a scene.
namespace kinome::check {

inline RayHit ray_hit(const Vec3& o, const Vec3& d) {
  RayHit ray;
  ray.ray.o = o;
  ray.ray.d = d;
  return ray;
}

/// Returns the nearest hit of one ray.
inline RayHit trace(const Scene& scene, const Vec3& o, const Vec3& d) {
  RayHit ray = ray_hit(o, d);
  RenderCounters counters;
  scene.intersect({&ray, 1}, Coherence::kIncoherent, counters);
  return ray;
}

/// Returns the sum of `pdf` over all points of surfaces on the ray from p along d, including hidden
/// ones: the density of the direction.
inline float density_along(const Scene& scene, const Vec3& p, const Vec3& d,
                           const std::function<float(const SurfaceInteraction&)>& pdf) {
  float sum = 0;
  Vec3 o = p;
  for (int i = 0; i < 8; ++i) {
    const RayHit hit = trace(scene, o, d);
    if (!hit.hit.valid()) break;
    const SurfaceInteraction si = scene.interaction(hit);
    sum += pdf(si);
    o = si.ray_origin(d);
  }
  return sum;
}

}  // namespace kinome::check

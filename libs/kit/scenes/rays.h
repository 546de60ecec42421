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
inline RayHit trace(const Scene& scene, const Vec3& o, const Vec3& d, float tmin = 0,
                    float tmax = kInfinity) {
  RayHit ray = ray_hit(o, d);
  ray.ray.tmin = tmin;
  ray.ray.tmax = tmax;
  RenderCounters counters;
  scene.intersect({&ray, 1}, Coherence::kIncoherent, counters);
  return ray;
}

/// Calls use(hit, interaction) for each hit along a ray, up to `max_hits`, and returns their
/// number.
template <class Use>
int for_each_hit(const Scene& scene, Vec3 o, const Vec3& d, int max_hits, const Use& use) {
  for (int count = 0; count < max_hits; ++count) {
    const RayHit hit = trace(scene, o, d);
    if (!hit.hit.valid()) return count;
    const SurfaceInteraction si = scene.interaction(hit);
    use(hit, si);
    o = si.ray_origin(d);
  }
  return max_hits;
}

/// Returns the sum of `pdf` over all points of surfaces on the ray from p along d, including hidden
/// ones: the density of the direction.
inline float density_along(const Scene& scene, const Vec3& p, const Vec3& d,
                           const std::function<float(const SurfaceInteraction&)>& pdf) {
  float sum = 0;
  for_each_hit(scene, p, d, 8,
               [&](const RayHit&, const SurfaceInteraction& si) { sum += pdf(si); });
  return sum;
}

}  // namespace kinome::check

#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/blocks.h"
#include "kinome/interaction.h"
#include "kinome/wide/vectors.h"

namespace kinome::transport {

/// Sets shadow rays from points i … toward light at `distance` along the unit vectors d, like
/// SurfaceInteraction::shadow_ray(). Rays are inactive where `on` is false. `finite` must be true
/// if some distances are finite. tmin of the rays must be 0, as in new arenas.
KINOME_WIDE void write_shadow_rays(const SurfaceBlock& points, size_t i, const wide::Vec3& d,
                                   wide::Float distance, wide::Mask on, bool finite, Ray16* rays) {
  using namespace wide;
  const wide::Vec3 p = wide::Vec3::load(points.p, i), n = wide::Vec3::load(points.n, i);
  const Float error = Float::load(points.p_error + i);
  const ShadowRayOf<wide::Vec3, Float> shadow(p, n, error, d, distance, finite);
  Ray16& out = rays[i / kBlockLanes];
  const size_t lane = i % kBlockLanes;
  shadow.o.store({out.ox, out.oy, out.oz}, lane);
  shadow.d.store({out.dx, out.dy, out.dz}, lane);
  select(on, shadow.tmax, -1.f).store(out.tmax + lane);
}

/// Adds light to the radiance of the samples owner[0], owner[1] ... where `on`. These samples must
/// be distinct.
KINOME_WIDE void add_to_owners(wide::Rgb light, wide::Mask on, const uint32_t* owner,
                               const Columns3& radiance) {
  using namespace wide;
  if (none(on)) return;
  const uint32_t first = owner[0];
  if (all(Int::load(owner) == iota() + static_cast<int32_t>(first))) {
    (wide::Rgb::load(radiance, first) + select(on, light)).store(radiance, first);
    return;
  }
  alignas(kColumnAlignment) float x[kLanes], y[kLanes], z[kLanes];
  alignas(kColumnAlignment) uint32_t to[kLanes];
  selected_first(on, light.x).store(x);
  selected_first(on, light.y).store(y);
  selected_first(on, light.z).store(z);
  const size_t count = store_selected(on, Uint::load(owner), to);
  for (size_t k = 0; k < count; ++k) {
    radiance.x[to[k]] += x[k];
    radiance.y[to[k]] += y[k];
    radiance.z[to[k]] += z[k];
  }
}

/// Prepares rays for tracing: marks each as having no hit.
inline void clear_hits(RayHit16* rays, size_t count) {
  for (size_t k = 0; k < padded(count) / kBlockLanes; ++k) {
    std::fill_n(rays[k].shape, kBlockLanes, kNoHit);
    std::fill_n(rays[k].instance, kBlockLanes, kNoHit);
  }
}

/// Distance from a point, along the normal, at which a ray continues behind it, as a multiple of
/// p_error: one p_error for the surface, one for the nearest point of the ray.
inline constexpr float kErrorsBehind = 2;
/// Minimum cosine in this distance, for rays at grazing angles.
inline constexpr float kMinCosineBehind = 1e-3f;

/// Returns the distance along a ray at which it continues behind a point that it hit. The ray stays
/// on its line; origins off the surfaces would move its end sideways, and toward the emitter.
inline float distance_behind(const Ray& ray, const kinome::Vec3& p, const kinome::Vec3& n,
                             float error) {
  const float cosine = std::max(std::abs(glm::dot(n, ray.d)), kMinCosineBehind);
  return glm::dot(p - ray.o, ray.d) + kErrorsBehind * error / cosine;
}

/// Copies ray `i` of `from` and its hit to ray k of `to`, except for its time and mask.
inline void copy_ray_hit(const RayHit16* from, size_t i, RayHit16* to, size_t k) {
  const RayHit one = ray_hit_of(from, i);
  RayHit16& block = to[k / kBlockLanes];
  const size_t at = k % kBlockLanes;
  set_ray(block.ray, at, one.ray);
  block.ngx[at] = one.hit.ng.x, block.ngy[at] = one.hit.ng.y, block.ngz[at] = one.hit.ng.z;
  block.u[at] = one.hit.u, block.v[at] = one.hit.v;
  block.primitive[at] = one.hit.primitive;
  block.shape[at] = one.hit.shape, block.instance[at] = one.hit.instance;
}

}  // namespace kinome::transport

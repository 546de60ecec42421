#pragma once

#include <algorithm>

#include "kinome/blocks.h"
#include "kinome/wide/vectors.h"

namespace kinome::transport {

/// Where ray k of blocks of 16 has its value of a column, in floats from that of ray 0.
KINOME_WIDE wide::Int offset_of(const Ray16*, wide::Int k) {
  return wide::shift_right<4>(k) * wide::Int(static_cast<int32_t>(sizeof(Ray16) / 4)) +
         (k & wide::Int(15));
}
KINOME_WIDE wide::Int offset_of(const RayHit16*, wide::Int k) {
  return wide::shift_right<4>(k) * wide::Int(static_cast<int32_t>(sizeof(RayHit16) / 4)) +
         (k & wide::Int(15));
}

/// Shadow rays from points i … toward light at `distance` along the unit vectors d, as
/// SurfaceInteraction::shadow_ray makes them; off where `on` is false. `finite`: some may be near.
KINOME_WIDE void put_shadow_rays(const SurfaceBlock& points, size_t i, wide::Vec3 d,
                                 wide::Float distance, wide::Mask on, bool finite, Ray16* rays) {
  using namespace wide;
  const wide::Vec3 p = wide::Vec3::load(points.p, i), n = wide::Vec3::load(points.n, i);
  const Float error = Float::load(points.p_error + i);
  const wide::Vec3 o = p + n * copysign(error, dot(n, d));
  Float tmax = kInfinity;
  if (finite) {
    const Mask near = distance < kInfinity;
    const wide::Vec3 to = p + d * select(near, distance, 1.f) - o;
    const Float length_to = length(to);
    d = select(near, to / length_to, d);
    tmax = select(near, max(length_to * (1 - 1e-4f) - error, 0.f), kInfinity);
  }
  Ray16& out = rays[i / kBlockLanes];
  const size_t lane = i % kBlockLanes;
  o.store({out.ox, out.oy, out.oz}, lane);
  d.store({out.dx, out.dy, out.dz}, lane);
  Float(0.f).store(out.tmin + lane);
  select(on, tmax, -1.f).store(out.tmax + lane);
}

/// Before rays are traced: nothing is hit.
inline void clear_hits(RayHit16* rays, size_t count) {
  for (size_t k = 0; k < padded(count) / kBlockLanes; ++k) {
    std::fill_n(rays[k].shape, kBlockLanes, kNoHit);
    std::fill_n(rays[k].instance, kBlockLanes, kNoHit);
  }
}

}  // namespace kinome::transport

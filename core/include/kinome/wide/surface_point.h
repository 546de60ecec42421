#pragma once

// Surface points computed by formulas over F, and their conversion to a SurfaceInteraction or to
// values of a SurfaceBlock.

#include "kinome/blocks.h"
#include "kinome/interaction.h"
#include "kinome/wide/near_indices.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

inline namespace formulas {

/// Returns v / |v| without under- or overflow of |v|², or `fallback` if v is zero or not finite.
/// Cross products of a small mesh's edges, scaled by 1e-6, have squares below the smallest float.
template <class V>
KINOME_WIDE V safe_normalize(const V& v, const V& fallback) {
  using F = NumberOf<V>;
  // Common case, which avoids the latency of a first division.
  const F length2 = dot(v, v);
  const MaskOf<F> is_normal_number = length2 > 1e-20f && length2 < 1e20f;
  const V unit = v / sqrt(length2);
  if (all(is_normal_number)) return unit;
  const F scale = max_component(abs(v));
  const MaskOf<F> is_direction = scale > 0.f && scale < HUGE_VALF;
  return select(is_normal_number, unit, select(is_direction, normalize(v / scale), fallback));
}

/// Density per solid angle of a surface point sampled uniformly by area. `to` is the vector from
/// the reference point to it; n is the surface's unit normal. 0 if the surface is edge-on, or the
/// result is not finite.
template <class V>
KINOME_WIDE auto solid_angle_density(const V& to, const V& n, float area) {
  const auto distance2 = dot(to, to);
  const auto distance = sqrt(distance2);
  const auto projected = abs(dot(n, to)) * area;  // |cos| x distance x area
  const auto pdf = distance2 / projected * distance;
  return select(projected > 0.f && is_finite(pdf), pdf);
}

/// Fields of SurfaceInteraction that a shape sets.
template <class F>
struct ShapePoint {
  VecOf<F> p;
  F p_error;
  VecOf<F> n;
  FrameOf<VecOf<F>> frame;
  VecOf<F> dp_du, dp_dv;
  Vec2Of<F> uv;
  VecOf<F> wi;
};

}  // namespace formulas

KINOME_WIDE SurfaceInteraction interaction_of(const formulas::ShapePoint<float>& point) {
  SurfaceInteraction si;
  si.p = point.p;
  si.p_error = point.p_error;
  si.n = point.n;
  si.frame = point.frame;
  si.dp_du = point.dp_du;
  si.dp_dv = point.dp_dv;
  si.uv = point.uv;
  si.wi = point.wi;
  return si;
}

/// Stores values i, i + 1 … of the block, except primitive, ray and shape.
KINOME_WIDE void store(const formulas::ShapePoint<Float>& point, const SurfaceBlock& out,
                       size_t i) {
  point.p.store(out.p, i);
  point.p_error.store(out.p_error + i);
  point.n.store(out.n, i);
  point.frame.s.store(out.s, i);
  point.frame.t.store(out.t, i);
  point.frame.n.store(out.sn, i);
  if (out.dp_du.x) point.dp_du.store(out.dp_du, i);
  if (out.dp_dv.x) point.dp_dv.store(out.dp_dv, i);
  point.uv.store(out.uv, i);
  point.wi.store(out.wi, i);
}

/// Shading frames of points i, i + 1 …
KINOME_WIDE FrameOf<Vec3> frame_at(const SurfaceBlock& points, size_t i) {
  return {Vec3::load(points.s, i), Vec3::load(points.t, i), Vec3::load(points.sn, i)};
}

/// Implements Shape::pdf_solid_angle_block() for shapes sampled uniformly by area.
inline void store_solid_angle_densities(const Columns3& p, const SurfaceBlock& points, float area,
                                        float* pdf) {
  for_lanes(points.count, [&](size_t i) {
    const Vec3 to = Vec3::load(points.p, i) - Vec3::load(p, i);
    formulas::solid_angle_density(to, Vec3::load(points.n, i), area).store(pdf + i);
  });
}

/// Fields of rays gathered by ray index, from blocks of 16.
class GatheredRays {
 public:
  KINOME_WIDE GatheredRays(const RayHit16* rays, const uint32_t* numbers)
      : rays_(*rays), at_(numbers, [](auto k) { return offset(k); }) {}
  KINOME_WIDE Vec3 o() const { return in(rays_.ray.ox, rays_.ray.oy, rays_.ray.oz); }
  KINOME_WIDE Vec3 d() const { return in(rays_.ray.dx, rays_.ray.dy, rays_.ray.dz); }
  KINOME_WIDE Float tmax() const { return at_.in(rays_.ray.tmax); }
  KINOME_WIDE Float u() const { return at_.in(rays_.u); }
  KINOME_WIDE Float v() const { return at_.in(rays_.v); }
  KINOME_WIDE Uint primitive() const { return at_.in(rays_.primitive); }

 private:
  /// Returns the offset in values from a field of ray 0 to that of ray k.
  template <class I>
  KINOME_WIDE static I offset(I k) {
    constexpr auto block = static_cast<int32_t>(sizeof(RayHit16) / sizeof(float));
    return shift_right<4>(k) * block + (k & 15);
  }
  KINOME_WIDE Vec3 in(const float* x, const float* y, const float* z) const {
    return {at_.in(x), at_.in(y), at_.in(z)};
  }
  const RayHit16& rays_;
  NearIndices at_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide

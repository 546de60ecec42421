#include "clustered/kernels/local_kernels.h"

#include "clustered/kernels/lobe_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clustered/kernels/local_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kLobeLanes>;
using V = hn::Vec<Tag>;

HWY_INLINE V Dot(const V a[3], const V b[3]) {
  return hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
}

void ConnectPoints(const LightPointColumns& points, const SurfacePoint& from, size_t count,
                   const ConnectionColumns& out) {
  const Tag d;
  const V zero = hn::Zero(d), tiny = hn::Set(d, 1e-18f), one = hn::Set(d, 1.f);
  const V error = hn::Set(d, from.error);
  V origin[3], plane[3];
  for (int k = 0; k < 3; ++k) {
    origin[k] = hn::Set(d, from.position[k]);
    plane[k] = hn::Set(d, from.geometric[k]);
  }
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    V to[3], normal[3], geometric[3];
    for (int k = 0; k < 3; ++k) {
      to[k] = hn::Sub(hn::LoadU(d, points.position[k] + i), origin[k]);
      normal[k] = hn::LoadU(d, points.normal[k] + i);
      geometric[k] = hn::LoadU(d, points.geometric[k] + i);
    }
    const V squared = Dot(to, to);
    const V height = hn::Abs(Dot(to, plane));
    const V distance = hn::Sqrt(squared);
    const V inverse = hn::Div(one, hn::Max(distance, tiny));
    for (V& v : to) v = hn::Mul(v, inverse);
    const auto faces = hn::And(hn::Lt(Dot(normal, to), zero), hn::Gt(height, error));
    const V geometry = hn::Mul(hn::Abs(Dot(geometric, to)), hn::Mul(inverse, inverse));
    const V lit = hn::IfThenElseZero(faces, geometry);
    V radiance[3];
    for (int k = 0; k < 3; ++k) radiance[k] = hn::Mul(hn::LoadU(d, points.power[k] + i), lit);
    hn::StoreInterleaved3(radiance[0], radiance[1], radiance[2], d, out.radiance + 3 * i);
    hn::StoreU(hn::Mul(hn::LoadU(d, points.eye_ratio + i), geometry), d, out.eye_ratio + i);
    hn::StoreU(to[0], d, out.dx + i);
    hn::StoreU(to[1], d, out.dy + i);
    hn::StoreU(to[2], d, out.dz + i);
    hn::StoreU(distance, d, out.distance + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinome::simd {

HWY_EXPORT(ConnectPoints);

void connect_points(const LightPointColumns& points, const SurfacePoint& from, size_t count,
                    const ConnectionColumns& out) {
  HWY_DYNAMIC_DISPATCH(ConnectPoints)(points, from, count, out);
}

}  // namespace kinome::simd
#endif

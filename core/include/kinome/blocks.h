#pragma once

#include <cstddef>
#include <cstdint>

#include "kinome/columns.h"
#include "kinome/lobe.h"
#include "kinome/math.h"
#include "kinome/ray.h"

/// What the stages of a renderer that works on blocks hand on to one another, and to plugins: some
/// two thousand samples at a time, as structures of arrays (columns.h).
///
/// Every function over a block takes columns that are aligned to 64 bytes and padded to whole
/// vectors (padded(count)). All of a column may be read and written, its padding included; what
/// stands in the padding afterwards means nothing. Padding of indices holds valid ones; of numbers
/// it may hold anything, NaN included. Such functions are const and called from many threads.
namespace kinome {

class Shape;

/// 16 rays, laid out as Embree's RTCRay16; see Ray. A lane is off where tmax < tmin.
struct alignas(64) Ray16 {
  float ox[16], oy[16], oz[16], tmin[16];
  float dx[16], dy[16], dz[16], time[16];
  float tmax[16];  ///< -infinity where Scene::occluded found something
  uint32_t mask[16], id[16], flags[16];
};

/// 16 rays with what they hit, laid out as Embree's RTCRayHit16; see Hit.
struct alignas(64) RayHit16 {
  Ray16 ray;
  float ngx[16], ngy[16], ngz[16], u[16], v[16];
  uint32_t primitive[16];
  uint32_t shape[16];  ///< index into Scene::shapes(), or kNoHit
  uint32_t instance[16];
  uint32_t spare[16];  ///< of later versions of Embree
};

/// Sets what no sensor or stage writes: no time, all of the mask.
inline void reset(Ray16& rays) {
  rays = Ray16{};
  for (uint32_t& mask : rays.mask) mask = ~0u;
}

/// Ray k of blocks of 16, and what it hit.
inline Ray ray_of(const Ray16* rays, size_t k) {
  const Ray16& b = rays[k / 16];
  const size_t i = k % 16;
  Ray ray;
  ray.o = {b.ox[i], b.oy[i], b.oz[i]};
  ray.tmin = b.tmin[i];
  ray.d = {b.dx[i], b.dy[i], b.dz[i]};
  ray.time = b.time[i];
  ray.tmax = b.tmax[i];
  return ray;
}
inline RayHit ray_hit_of(const RayHit16* rays, size_t k) {
  const RayHit16& b = rays[k / 16];
  const size_t i = k % 16;
  RayHit hit;
  hit.ray = ray_of(&b.ray, i);
  hit.hit = {{b.ngx[i], b.ngy[i], b.ngz[i]}, b.u[i],     b.v[i],
             b.primitive[i],                 b.shape[i], b.instance[i]};
  return hit;
}

/// Samples first_sample … first_sample + samples - 1 of some pixels: number p * samples + s is the
/// s-th of them of pixel p.
struct PixelSamples {
  const uint32_t* x;  ///< of each pixel, as SampleKey has it
  const uint32_t* y;
  size_t pixels;
  uint32_t first_sample;
  uint32_t samples;
  uint64_t seed;
  size_t count() const { return pixels * samples; }
};

/// Points of surfaces, each seen along a ray: SurfaceInteraction by columns.
struct SurfaceBlock {
  size_t count = 0;
  Columns3 p;      ///< place
  Columns3 n;      ///< unit geometric normal
  Columns3 s, t;   ///< with sn the shading frame, orthonormal
  Columns3 sn;     ///< shading normal
  Columns3 dp_du;  ///< as SurfaceInteraction; its columns are nullptr where nobody asks
  Columns3 dp_dv;
  Columns3 wi;  ///< unit, toward where the ray came from, in the shading frame
  Columns2 uv;
  float* p_error = nullptr;
  uint32_t* primitive = nullptr;
  uint32_t* ray = nullptr;         ///< number of the ray that found it
  const Shape** shape = nullptr;   ///< whose surface it is

  /// Points first … first + length - 1; `first` is a multiple of kBlockLanes.
  SurfaceBlock part(size_t first, size_t length) const {
    const auto wanted = [&](const Columns3& c) { return c.x ? c.from(first) : Columns3{}; };
    return {length,          p.from(first),   n.from(first),     s.from(first),
            t.from(first),   sn.from(first),  wanted(dp_du),     wanted(dp_dv),
            wi.from(first),  uv.from(first),  p_error + first,   primitive + first,
            ray + first,     shape + first};
  }
};

/// What a BSDF is asked at each point of a block: its value for one direction, and a sample. Either
/// may be left out, its columns being nullptr.
struct BsdfQuery {
  Columns3 wo;   ///< unit, in the shading frame
  float* u1 = nullptr;
  Columns2 u2;
  Lobe lobes = Lobe::kAll;  ///< values, densities and samples are those of these alone

  BsdfQuery from(size_t i) const {
    BsdfQuery part;
    part.lobes = lobes;
    if (wo.x) part.wo = wo.from(i);
    if (u1) part.u1 = u1 + i, part.u2 = u2.from(i);
    return part;
  }
};

/// Value of BsdfAnswer::is_delta for samples that go straight through the surface (Lobe::kNull).
inline constexpr float kNullSample = 2;

/// Its answers: as BsdfValue for query.wo, and as BsdfSample.
struct BsdfAnswer {
  Columns3 f;            ///< BSDF x |cos theta_o| [1/sr]; 0 where pdf is 0
  float* pdf = nullptr;  ///< of sampling wo, per solid angle
  Columns3 wo;           ///< the sample's direction
  Columns3 weight;       ///< f |cos theta_o| / pdf; 0 where there is no sample
  float* sample_pdf = nullptr;  ///< per solid angle; 1 for a delta lobe; 0: there is no sample
  /// 1 if the sample is of a delta lobe, kNullSample if it is of kDelta | kNull, else 0.
  float* is_delta = nullptr;

  BsdfAnswer from(size_t i) const {
    return {f.from(i), pdf + i, wo.from(i), weight.from(i), sample_pdf + i, is_delta + i};
  }
};

/// Light that goes straight through the points of a block: NullTransmission by columns.
struct NullTransmissionBlock {
  Columns3 transmittance;
  float* probability = nullptr;

  NullTransmissionBlock from(size_t i) const { return {transmittance.from(i), probability + i}; }
};

/// Directions toward a light: DirectSample by columns.
struct DirectBlock {
  Columns3 d;                 ///< unit, from the point toward the light
  float* distance = nullptr;  ///< infinite for distant light
  float* pdf = nullptr;       ///< per solid angle; 1 where is_delta; 0: there is no sample
  Columns3 radiance;          ///< for a delta light, irradiance on a facing surface
  float* is_delta = nullptr;  ///< 1 or 0

  DirectBlock from(size_t i) const {
    return {d.from(i), distance + i, pdf + i, radiance.from(i), is_delta + i};
  }
};

/// Light that leaves an emitter: of EmissionSample the ray and the power, by columns.
struct EmissionBlock {
  Columns3 o;      ///< off the surface, as EmissionSample::ray has it
  Columns3 d;      ///< unit
  Columns3 power;  ///< [W]; black: there is no sample

  EmissionBlock from(size_t i) const { return {o.from(i), d.from(i), power.from(i)}; }
};

/// How a camera sees points: SensorConnection by columns.
struct ConnectionBlock {
  Columns2 film_position;
  Columns3 d;                 ///< unit, whether or not the point is seen
  float* distance = nullptr;
  float* weight = nullptr;    ///< 0: the camera doesn't see the point

  ConnectionBlock from(size_t i) const {
    return {film_position.from(i), d.from(i), distance + i, weight + i};
  }
};

/// Points of a surface, each chosen as seen from another point: SurfaceSample by columns.
struct SurfaceSampleBlock {
  Columns3 p;            ///< place
  Columns3 sn;           ///< shading normal
  Columns2 uv;           ///< nullptr where nobody asks
  float* pdf = nullptr;  ///< per solid angle at the other point; 0: there is no sample

  SurfaceSampleBlock from(size_t i) const {
    return {p.from(i), sn.from(i), uv.x ? uv.from(i) : Columns2{}, pdf + i};
  }
};

/// The nearest hits of 16 rays with one analytic shape.
struct alignas(64) ShapeHit16 {
  float t[16];  ///< infinite: none in [tmin, tmax]
  float ngx[16], ngy[16], ngz[16];  ///< as Hit::ng; zeros unless a shape sets them
  float u[16], v[16];
  uint32_t primitive[16];
};

}  // namespace kinome

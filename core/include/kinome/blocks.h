#pragma once

#include <cstddef>
#include <cstdint>

#include "kinome/columns.h"
#include "kinome/lobe.h"
#include "kinome/math.h"
#include "kinome/ray.h"

/// Data that the stages of a block-wise renderer pass to each other and to plugins. A block has
/// about two thousand samples, stored as structures of arrays (columns.h).
///
/// All functions on blocks take columns aligned to 64 bytes and padded to whole vectors (see
/// padded()). They may read and write a column including its padding, whose contents are undefined
/// afterwards. Padding of index columns holds valid indices; other padding may hold anything, NaN
/// included. Block functions are const and called from many threads.
namespace kinome {

class Shape;

/// 16 rays in the layout of Embree's RTCRay16 (see Ray). A lane is inactive if tmax < tmin.
struct alignas(64) Ray16 {
  float ox[16], oy[16], oz[16], tmin[16];
  float dx[16], dy[16], dz[16], time[16];
  float tmax[16];  ///< -infinity if Scene::occluded() found an occluder
  uint32_t mask[16], id[16], flags[16];
};

/// 16 rays with their hits, in the layout of Embree's RTCRayHit16 (see Hit).
struct alignas(64) RayHit16 {
  Ray16 ray;
  float ngx[16], ngy[16], ngz[16], u[16], v[16];
  uint32_t primitive[16];
  uint32_t shape[16];  ///< index into Scene::shapes(), or kNoHit
  uint32_t instance[16];
  uint32_t spare[16];  ///< reserved for later versions of Embree
};

/// Clears the rays and sets the fields that no sensor or stage writes: time 0, full mask.
inline void reset(Ray16& rays) {
  rays = Ray16{};
  for (uint32_t& mask : rays.mask) mask = ~0u;
}

/// Returns ray k of an array of 16-ray blocks.
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
/// Sets ray `lane` of a block, except for its time and mask.
inline void set_ray(Ray16& rays, size_t lane, const Ray& ray) {
  rays.ox[lane] = ray.o.x, rays.oy[lane] = ray.o.y, rays.oz[lane] = ray.o.z;
  rays.dx[lane] = ray.d.x, rays.dy[lane] = ray.d.y, rays.dz[lane] = ray.d.z;
  rays.tmin[lane] = ray.tmin, rays.tmax[lane] = ray.tmax;
}
/// Disables the padding of `count` rays.
inline void disable_padding(Ray16* rays, size_t count) {
  for (size_t i = count; i < padded(count); ++i) rays[i / 16].tmax[i % 16] = -1;
}
inline void disable_padding(RayHit16* rays, size_t count) {
  for (size_t i = count; i < padded(count); ++i) rays[i / 16].ray.tmax[i % 16] = -1;
}
/// Returns ray k and its hit.
inline RayHit ray_hit_of(const RayHit16* rays, size_t k) {
  const RayHit16& b = rays[k / 16];
  const size_t i = k % 16;
  RayHit hit;
  hit.ray = ray_of(&b.ray, i);
  hit.hit = {{b.ngx[i], b.ngy[i], b.ngz[i]}, b.u[i],     b.v[i],
             b.primitive[i],                 b.shape[i], b.instance[i]};
  return hit;
}

/// Samples first_sample … first_sample + samples - 1 of several pixels. Sample s of pixel p has
/// index p * samples + s.
struct PixelSamples {
  const uint32_t* x;  ///< per pixel, as SampleKey::x
  const uint32_t* y;
  size_t pixels;
  uint32_t first_sample;
  uint32_t samples;
  uint64_t seed;
  size_t count() const { return pixels * samples; }
};

/// Surface points, each seen along a ray: columns of SurfaceInteraction.
struct SurfaceBlock {
  size_t count = 0;
  Columns3 p;      ///< position
  Columns3 n;      ///< unit geometric normal
  Columns3 s, t;   ///< tangents of the shading frame (s, t, sn)
  Columns3 sn;     ///< shading normal
  Columns3 dp_du;  ///< as in SurfaceInteraction; nullptr if not needed
  Columns3 dp_dv;
  Columns3 wi;  ///< unit, toward the ray's origin, in the shading frame
  Columns2 uv;
  float* p_error = nullptr;
  uint32_t* primitive = nullptr;
  uint32_t* ray = nullptr;        ///< index of the ray that hit the point
  const Shape** shape = nullptr;  ///< shape that the point is on

  /// Returns points first … first + length - 1; `first` is a multiple of kBlockLanes.
  SurfaceBlock part(size_t first, size_t length) const {
    const auto wanted = [&](const Columns3& c) { return c.x ? c.from(first) : Columns3{}; };
    return {length,          p.from(first),   n.from(first),     s.from(first),
            t.from(first),   sn.from(first),  wanted(dp_du),     wanted(dp_dv),
            wi.from(first),  uv.from(first),  p_error + first,   primitive + first,
            ray + first,     shape + first};
  }
};

/// Input of Bsdf::shade_block() at each point: a direction to evaluate, and random numbers for a
/// sample. Either may be omitted by leaving its columns nullptr.
struct BsdfQuery {
  Columns3 wo = {};  ///< unit, in the shading frame
  float* u1 = nullptr;
  Columns2 u2 = {};
  Lobe lobes = Lobe::kAll;  ///< restricts value, density and sample to these lobes

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

/// Output of Bsdf::shade_block(): BsdfValue for query.wo, and BsdfSample.
struct BsdfAnswer {
  Columns3 f;            ///< BSDF x |cos theta_o| [1/sr]; 0 where pdf is 0
  float* pdf = nullptr;  ///< density of sampling query.wo, per solid angle
  Columns3 wo;           ///< sampled direction
  Columns3 weight;       ///< f |cos theta_o| / pdf; 0 without a sample
  float* sample_pdf = nullptr;  ///< per solid angle; 1 for a delta lobe; 0 without a sample
  /// 1 for a sample of a delta lobe, kNullSample for kDelta | kNull, otherwise 0.
  float* is_delta = nullptr;

  BsdfAnswer from(size_t i) const {
    return {f.from(i), pdf + i, wo.from(i), weight.from(i), sample_pdf + i, is_delta + i};
  }
};

/// Straight transmission at the points of a block: columns of NullTransmission.
struct NullTransmissionBlock {
  Columns3 transmittance;
  float* probability = nullptr;

  NullTransmissionBlock from(size_t i) const { return {transmittance.from(i), probability + i}; }
};

/// Directions toward an emitter: columns of DirectSample.
struct DirectBlock {
  Columns3 d;                 ///< unit, from the point toward the emitter
  float* distance = nullptr;  ///< infinite for distant light
  float* pdf = nullptr;       ///< per solid angle; 1 if is_delta; 0 without a sample
  Columns3 radiance;          ///< for a delta emitter, irradiance on a surface that faces it
  float* is_delta = nullptr;  ///< 1 or 0

  DirectBlock from(size_t i) const {
    return {d.from(i), distance + i, pdf + i, radiance.from(i), is_delta + i};
  }
};

/// Rays that leave an emitter: ray and power of EmissionSample, as columns.
struct EmissionBlock {
  Columns3 o;      ///< off the surface, as in EmissionSample::ray()
  Columns3 d;      ///< unit
  Columns3 power;  ///< [W]; black without a sample

  EmissionBlock from(size_t i) const { return {o.from(i), d.from(i), power.from(i)}; }
};

/// Connections from surface points to the camera: columns of SensorConnection.
struct ConnectionBlock {
  Columns2 film_position;
  Columns3 d;  ///< unit; also set if the point isn't seen
  float* distance = nullptr;
  float* weight = nullptr;  ///< 0 if the camera doesn't see the point

  ConnectionBlock from(size_t i) const {
    return {film_position.from(i), d.from(i), distance + i, weight + i};
  }
};

/// Surface points, each sampled as seen from a reference point: columns of SurfaceSample.
struct SurfaceSampleBlock {
  Columns3 p;            ///< position
  Columns3 sn;           ///< shading normal
  Columns2 uv;           ///< nullptr if not needed
  float* pdf = nullptr;  ///< per solid angle at the reference point; 0 without a sample

  SurfaceSampleBlock from(size_t i) const {
    return {p.from(i), sn.from(i), uv.x ? uv.from(i) : Columns2{}, pdf + i};
  }
};

/// Nearest hits of 16 rays with one analytic shape.
struct alignas(64) ShapeHit16 {
  float t[16];                      ///< infinity if there is no hit in [tmin, tmax]
  float ngx[16], ngy[16], ngz[16];  ///< see Hit::ng; 0 unless the shape sets it
  float u[16], v[16];
  uint32_t primitive[16];
};

}  // namespace kinome

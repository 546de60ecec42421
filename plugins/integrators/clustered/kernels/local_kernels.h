#pragma once

#include <cstddef>
#include <cstdint>

/// Kernels over light points as one surface point sees them. Arrays are padded to kLobeLanes values
/// (lobe_kernels.h), which are read and written; padding is points of no power.
namespace kinome::simd {

/// Light points (see LightPoint), as structure of arrays.
struct LightPointColumns {
  const float* position[3];
  const float* normal[3];
  const float* geometric[3];
  const float* power[3];
  const float* eye_ratio;
};

/// The numbers of one light point beside one another, in a line of the cache.
struct alignas(64) LightPointRow {
  float position[3];
  float normal[3];
  float geometric[3];
  float power[3];
  float eye_ratio;
};
inline constexpr size_t kLightPointNumbers = 13;
/// Rows `index` of some rows, and factors of their powers and eye ratios.
struct PickedRows {
  const uint32_t* index;
  const float* weight;
  const float* eye_weight;
};
/// Writes the picked rows as columns, in the order of a row's numbers.
void gather_points(const LightPointRow* rows, const PickedRows& picks, size_t count,
                   float* const (&columns)[kLightPointNumbers]);

struct SurfacePoint {
  float position[3];
  float geometric[3];  ///< unit normal of the surface
  float error;         ///< bound on the distance of the position from the surface
};

/// What a surface point sees of light points.
struct ConnectionColumns {
  float *dx, *dy, *dz;  ///< unit
  float* distance;
  float* radiance;   ///< power x |cos'| / distance², r, g, b interleaved; 0 behind the point
  float* eye_ratio;  ///< the points' x |cos'| / distance²
};
/// A point in the plane of the surface sends nothing to it: as rounding has moved both, that is all
/// that can be known of points that are no higher than the error.
void connect_points(const LightPointColumns& points, const SurfacePoint& from, size_t count,
                    const ConnectionColumns& out);

}  // namespace kinome::simd

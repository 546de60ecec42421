#pragma once

#include <cstddef>
#include <cstdint>

/// Kernels over light points as seen from one surface point. Arrays are padded to kLobeLanes values
/// (lobe_kernels.h). The padding is read and written; it has points without power.
namespace kinome::simd {

/// Light points (see LightPoint), as structure of arrays.
struct LightPointColumns {
  const float* position[3];
  const float* normal[3];
  const float* geometric[3];
  const float* power[3];
  const float* eye_ratio;
};

/// The values of one light point as a row, in one cache line.
struct alignas(64) LightPointRow {
  float position[3];
  float normal[3];
  float geometric[3];
  float power[3];
  float eye_ratio;
};
inline constexpr size_t kLightPointNumbers = 13;
/// Selected rows, and factors of their powers and eye ratios.
struct PickedRows {
  const uint32_t* index;
  const float* weight;
  const float* eye_weight;
};
/// Writes the picked rows as columns, in the order of a row's values.
void gather_points(const LightPointRow* rows, const PickedRows& picks, size_t count,
                   float* const (&columns)[kLightPointNumbers]);

struct SurfacePoint {
  float position[3];
  float geometric[3];  ///< unit normal of the surface
  float error;         ///< bound on the distance of the position from the surface
};

/// Light points as seen from a surface point.
struct ConnectionColumns {
  float *dx, *dy, *dz;  ///< unit
  float* distance;
  float* radiance;   ///< power x |cos'| / distance², r, g, b interleaved; 0 behind the light point
  float* eye_ratio;  ///< eye ratio of the light point x |cos'| / distance²
};
/// Connects a surface point to light points. Light points within the error of the surface's plane
/// send nothing: due to rounding, they can't be distinguished from points in the plane.
void connect_points(const LightPointColumns& points, const SurfacePoint& from, size_t count,
                    const ConnectionColumns& out);

}  // namespace kinome::simd

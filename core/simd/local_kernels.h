#pragma once

#include <cstddef>
#include <cstdint>

/// Kernels over light points as one surface point sees them, compiled for every instruction set
/// that the compiler knows (Highway). Arrays are padded to kLobeLanes values (lobe_kernels.h),
/// which are read and written; padding is points of no power.
namespace kinome::simd {

/// Light points (see LightPoint), as structure of arrays.
struct LightPointColumns {
  const float* position[3];
  const float* normal[3];
  const float* geometric[3];
  const float* power[3];
  const float* eye_ratio;
};

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

/// Connections, weighed against rays that the surface's own BSDF sends (balance heuristic).
struct WeighedColumns {
  const float* f[3];  ///< BSDF x cosine
  const float* radiance;
  const uint32_t* cell;
  const float* density;  ///< of such a ray, per solid angle
  const float* eye_ratio;
  float* weight[3];
  float* uncertainty;  ///< |mean weight| x sigma of the cell
};
struct WeighingQuery {
  float eye_rays;           ///< expected number of such rays
  const float* visibility;  ///< of each cell
  const float* sigma;
};
/// weight = f x radiance / (1 + eye_rays x density x eye_ratio). control: sum of visibility x
/// weight. Sums of the uncertainties over blocks of kLobeLanes.
void weigh_connections(const WeighedColumns& columns, const WeighingQuery& query, size_t count,
                       float control[3], float* block_sums);

}  // namespace kinome::simd

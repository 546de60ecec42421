#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// Kernels over directions at many surface points, compiled for every instruction set that the
/// compiler knows (Highway). Arrays of directions are padded to kLobeLanes values, which are read
/// and written; padding points are point 0.
namespace kinome::simd {

inline constexpr size_t kLobeLanes = 16;

/// Frames of points, world space: normal, tangent (orthogonal to it), and the direction toward the
/// viewer; all unit vectors.
struct PointFrames {
  std::vector<float> normal[3];
  std::vector<float> tangent[3];
  std::vector<float> viewer[3];
  void resize(size_t points) {
    for (auto* const vectors : {normal, tangent, viewer}) {
      for (int axis = 0; axis < 3; ++axis) vectors[axis].resize(points);
    }
  }
};

/// A glossy lobe as of the GGX distribution of half vectors, with a roughness along the tangent and
/// one across.
struct HalfVectorLobe {
  float alpha_u;
  float alpha_v;
};

/// Mirrors the viewer at half vectors h of density D(h) cos(h): directions may lie below the
/// horizon. u1, u2: random numbers in [0, 1).
void sample_lobe(const HalfVectorLobe& lobe, const PointFrames& frames, const uint32_t* point,
                 const float* u1, const float* u2, size_t count, float* dx, float* dy, float* dz);

/// Density of sample_lobe for each direction, per solid angle.
void lobe_density(const HalfVectorLobe& lobe, const PointFrames& frames, const uint32_t* point,
                  const float* dx, const float* dy, const float* dz, size_t count, float* density);

/// Coordinates of unit directions of a local space, d = (sin phi sin theta, cos theta,
/// -cos phi sin theta): phi in [0, 2 pi] to 5e-7, as an arc, and theta in [0, pi] to 4e-7.
/// `to_local` is a matrix by rows.
void polar_angles(const float to_local[9], const float* dx, const float* dy, const float* dz,
                  size_t count, float* phi, float* theta);

}  // namespace kinome::simd

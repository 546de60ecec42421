#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clustered/kernels/aligned.h"

/// Kernels over directions at the points of a group. Arrays of directions are padded to kLobeLanes
/// values. The padding must have directions at member 0; kernels read and write it.
namespace kinome::simd {

inline constexpr size_t kLobeLanes = kBlockLanes;

/// Frames of points, world space: normal, tangent (orthogonal to it), and the direction toward the
/// viewer; all unit vectors.
struct PointFrames {
  Column<float> normal[3];
  Column<float> tangent[3];
  Column<float> viewer[3];
  void resize(size_t points) {
    for (auto* const vectors : {normal, tangent, viewer}) {
      for (int axis = 0; axis < 3; ++axis) vectors[axis].resize(points);
    }
  }
};

/// Points that share directions: member i has index points[i] in `frames`, 0 <= i < count. Groups
/// whose members fit eight vectors (128 with AVX-512) take less time for each direction.
struct PointGroup {
  const PointFrames& frames;
  const uint32_t* points;
  size_t count;
};

/// A glossy lobe with the GGX distribution of half vectors, with a roughness along the tangent and
/// one across.
struct HalfVectorLobe {
  float alpha_u;
  float alpha_v;
};

/// Random numbers in [0, 1) as 32-bit integers. Each is XORed with `shift`.
struct ShiftedNumbers {
  const uint32_t* u1;
  const uint32_t* u2;
  uint32_t shift[2];
};

/// Samples directions by reflecting the viewer at half vectors h of density D(h) cos(h). Directions
/// may be below the horizon. `member`: member of the group for each direction.
void sample_lobe(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                 const ShiftedNumbers& numbers, size_t count, float* dx, float* dy, float* dz);

/// Computes the density of sample_lobe for each direction, per solid angle.
void lobe_density(const HalfVectorLobe& lobe, const PointGroup& group, const uint32_t* member,
                  const float* dx, const float* dy, const float* dz, size_t count, float* density);

/// Properties that microfacet lobes of several points share; see BsdfForm.
struct MicrofacetKind {
  bool is_ggx = false;
  bool is_conductor = false;
  float eta[3] = {1, 1, 1};
  float k[3] = {};
};
/// Properties that may differ between points.
struct MicrofacetPoints {
  Column<float> alpha_u, alpha_v;
  Column<float> specular[3];
  void resize(size_t points) {
    alpha_u.resize(points);
    alpha_v.resize(points);
    for (auto& v : specular) v.resize(points);
  }
};
struct MicrofacetValues {
  float* f[3];
  float* density;
};
struct FirstMicrofacet {
  float alpha_u, alpha_v;
  float specular[3];
};
/// Computes f cos of each direction, three channels, and the density of sample_lobe. `varying` is
/// nullptr if all points have the properties of `first`.
void evaluate_microfacets(const MicrofacetKind& kind, const FirstMicrofacet& first,
                          const MicrofacetPoints* varying, const HalfVectorLobe& lobe,
                          const PointGroup& group, const uint32_t* member, const float* dx,
                          const float* dy, const float* dz, size_t count,
                          const MicrofacetValues& out);

/// Surface normals of points with other shading normals, and the roughness of bumps; see
/// wide::perturbed_normal_factor.
struct TurnedPoints {
  Column<float> normal[3];
  Column<float> bump_alpha2;
  void resize(size_t points) {
    for (auto& v : normal) v.resize(points);
    bump_alpha2.resize(points);
  }
};
/// Multiplies the three channels of f by wide::perturbed_normal_factor.
void multiply_turned_factors(const TurnedPoints& points, const PointGroup& group,
                             const uint32_t* member, const float* dx, const float* dy,
                             const float* dz, size_t count, float* const f[3]);

/// Diffuse lobes; see BsdfForm.
struct DiffusePoints {
  const Column<float> (&diffuse)[3];
  const float* transmittance;  ///< nullptr: 1
  const TurnedPoints* turned;  ///< nullptr if no normal is turned
};
/// Adds f cos of each direction to the three channels of f.
void add_diffuse(const DiffusePoints& points, const PointGroup& group, const uint32_t* member,
                 const float* dx, const float* dy, const float* dz, size_t count,
                 float* const f[3]);

/// Sets density = share x density of cosine-distributed directions + (1 - share) x density.
void mix_densities(float share, const PointGroup& group, const uint32_t* member, const float* dx,
                   const float* dy, const float* dz, size_t count, float* density);

}  // namespace kinome::simd

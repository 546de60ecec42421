#pragma once

#include <cstddef>
#include <cstdint>

/// Kernels that estimate how much of the light of cells or light points a patch of surface
/// reflects. Arrays are padded to kLobeLanes values (lobe_kernels.h), which are read and written.
namespace kinome::simd {

/// A patch of surface.
struct ReflectingPatch {
  float position[3];
  float normal[3];  ///< unit
  float viewer[3];  ///< unit, toward the viewer
  float diffuse;    ///< reflectance, mean of the channels
  float glossy;     ///< reflectance of the glossy lobe; 0 if there is none
  float alpha2;     ///< squared roughness of the glossy lobe, as of GGX
  /// Expected number of eye rays of a point, and the share of these that is distributed by the
  /// cosine alone.
  float eye_rays;
  float diffuse_share;
};

/// Estimates the fraction of light from a direction that a patch reflects toward the viewer [1/sr].
/// `arriving` is the cosine of the direction, plus a margin for the extents of patch and source.
/// `spread2` widens the lobe: squared extent of the source over its squared distance.
float reflected_fraction(const ReflectingPatch& patch, const float d[3], float arriving,
                         float spread2);

/// Mean values of cells.
struct CellMeans {
  const float* position[3];
  const float* normal[3];  ///< shorter than 1 if normals differ
  const float* spread2;    ///< variance of the position
  const float* flux;
};
/// Writes the importance of each cell to the patch: the estimated reflected light, times
/// visibility[i], its expected visibility.
void cell_importance(const ReflectingPatch& patch, const CellMeans& cells, const float* visibility,
                     size_t count, float* importance);

/// Light points, as structure of arrays.
struct EmittingPoints {
  const float* position[3];
  const float* normal[3];  ///< unit
  const float* power;      ///< mean of the channels
  const float* eye_ratio;  ///< see LightPointColumns
  const uint32_t* cell;
};
/// The same for light points, with the visibility of their cells. Light that eye rays find is
/// excluded by the weights of weigh_connections (candidate_kernels.h). `size2`: squared extent of
/// the patch, which bounds the importance of points that are very near.
void point_importance(const ReflectingPatch& patch, float size2, const EmittingPoints& points,
                      const float* visibility, size_t count, float* importance);

/// Lobes by which a surface reflects light to other surfaces, simplified.
struct SentLobe {
  float normal[3] = {0, 0, 1};  ///< unit
  float light[3] = {0, 0, 1};   ///< unit, toward the incident light
  float alpha2 = 1;             ///< squared roughness of the glossy lobe, as of GGX
  float diffuse = 0, glossy = 0;  ///< reflectance, mean of the channels
};
/// Estimates the BSDF times the cosine of the light, for the unit direction d. It is 0 only if the
/// true value is 0. spread2 widens the lobe: squared extent of the receiver over its squared
/// distance.
float sent_fraction(const SentLobe& lobe, const float d[3], float spread2);

/// Surface points that reflect light to other surfaces.
struct SendingPoints {
  const float* position[3];
  const float* normal[3];
  const float* light[3];
  const float *alpha2, *diffuse, *glossy;
};
/// Writes sent_fraction of each point toward the position of a patch with the squared extent
/// `size2`.
void sent_to_patch(const ReflectingPatch& patch, float size2, const SendingPoints& points,
                   size_t count, float* fraction);

/// Sets each visibility[i] to max(v[i], sigma[i], least).
void assumed_visibility(const float* v, const float* sigma, float least, size_t count,
                        float* visibility);

/// Adds `values`, scaled so that their sum is 1, to `sums`; adds nothing if their sum is 0 or isn't
/// finite.
void add_normalized(const float* values, size_t count, float* sums);

}  // namespace kinome::simd

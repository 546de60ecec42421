#pragma once

#include <cstddef>
#include <cstdint>

/// Kernels that estimate how much of the light of cells or light points a patch of surface reflects.
/// Arrays are padded to kLobeLanes values (lobe_kernels.h), which are read and written.
namespace kinome::simd {

/// A patch of surface.
struct ReflectingPatch {
  float position[3];
  float normal[3];  ///< unit
  float viewer[3];  ///< unit, toward the viewer
  float diffuse;    ///< reflectance, mean of the channels
  float glossy;     ///< reflectance of the glossy lobe; 0 if there is none
  float alpha2;     ///< squared roughness of the glossy lobe, as of GGX
  /// Expected number of rays that a point sends by its BSDF, and the share of these that depends on
  /// the cosine alone.
  float eye_rays;
  float diffuse_share;
};

/// Fraction of light from a direction that a patch reflects toward the viewer [1/sr], estimated.
/// `arriving` is the cosine of the direction, plus a margin for the extents of patch and source.
/// `spread2` widens the lobe: squared extent of the source over its squared distance.
float reflected_fraction(const ReflectingPatch& patch, const float d[3], float arriving,
                         float spread2);

/// Means of cells.
struct CellMeans {
  const float* position[3];
  const float* normal[3];  ///< shorter than 1 where normals differ
  const float* spread2;    ///< variance of the position
  const float* flux;
};
/// Writes the importance of each cell to the patch: the reflected light, estimated, times
/// visibility[i], the factor by which it may be shadowed.
void cell_importance(const ReflectingPatch& patch, const CellMeans& cells, const float* visibility,
                     size_t count, float* importance);

/// Light points.
struct EmittingPoints {
  const float* position[3];
  const float* normal[3];  ///< unit
  const float* power;      ///< mean of the channels
  const float* eye_ratio;  ///< as of LightPointColumns
  const uint32_t* cell;
};
/// The same for light points, with the visibility of their cells. Light that eye rays find is left
/// out, by the weights of weigh_connections (candidate_kernels.h). `size2`: squared extent of the
/// patch, which bounds the importance of points that are very near.
void point_importance(const ReflectingPatch& patch, float size2, const EmittingPoints& points,
                      const float* visibility, size_t count, float* importance);

/// Light that a surface sends on by its lobes, estimated.
struct SentLobe {
  float normal[3] = {0, 0, 1};  ///< unit
  float light[3] = {0, 0, 1};   ///< unit, toward the incident light
  float alpha2 = 1;             ///< squared roughness of the glossy lobe, as of GGX
  float diffuse = 0, glossy = 0;  ///< reflectance, mean of the channels
};
/// BSDF times the cosine of the light, for the unit direction d. It is not 0 where the true value
/// isn't. spread2 widens the lobe: squared extent of the receiver over its squared distance.
float sent_fraction(const SentLobe& lobe, const float d[3], float spread2);

/// Surface points that send light on.
struct SendingPoints {
  const float* position[3];
  const float* normal[3];
  const float* light[3];
  const float *alpha2, *diffuse, *glossy;
};
/// sent_fraction from each point toward the position of a patch, whose squared extent is `size2`.
void sent_to_patch(const ReflectingPatch& patch, float size2, const SendingPoints& points,
                   size_t count, float* fraction);

/// Sets each visibility[i] to max(v[i], sigma[i], least).
void believed_visibility(const float* v, const float* sigma, float least, size_t count,
                         float* visibility);

/// Adds `values`, scaled so that their sum is 1, to `sums`; adds nothing if their sum is 0 or isn't
/// finite.
void add_normalized(const float* values, size_t count, float* sums);

}  // namespace kinome::simd

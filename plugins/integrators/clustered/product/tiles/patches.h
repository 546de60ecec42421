#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clustered/product/tiles/primaries.h"
#include "clustered/product/tiles/visibility.h"
#include "kinome/wide/bsdf.h"

namespace kinome {

/// Members of a Patch that StoredPatch keeps as they are.
struct PatchValues {
  const Bsdf* bsdf = nullptr;
  Vec3 normal{0, 0, 1};          ///< mean
  Vec3 position{0.f};            ///< mean
  Vec3 viewer{0, 0, 1};          ///< mean, unit
  float cone_cosine = 1;         ///< cosine of the cone around `normal` that contains all normals
  float tolerance = 0;           ///< maximum distance of the patch's points from its plane
  Rgb diffuse{0.f};              ///< mean
  float glossy_reflectance = 0;  ///< of the first point, mean of channels
  uint32_t count = 0;            ///< number of the pilot's points
  uint32_t records_end = 0;  ///< of TileKnowledge: end of the patch's records in those of its tile
  /// True if all points have a BsdfForm of the same kind as Patch::form, so that kernels can
  /// evaluate them.
  bool is_described = false;
  bool is_uniform = false;  ///< also, the glossy lobes of all points are alike

  // Results of the plan, for one primary:
  bool trust = true;          ///< false if v doesn't predict the visibility of the glossy lobe well
  float glossy = 0;           ///< unshadowed glossy radiance
  float cell_share = 0.5f;    ///< fraction of candidates that are drawn from the cells
  float mean_visibility = 1;  ///< mean v of glossy light, and of local light except lamps
  float lamp_visibility = 1;
  /// Mean number of eye rays per primary, at most 1.
  float eye_rays = 0.5f;
};

/// A piece of surface of one material and nearly one normal, as a tile of pixels sees it. Its
/// points share learned visibility and a list of cells.
struct Patch : PatchValues {
  BsdfForm form;
  /// For a diffuse lobe without a form: its value relative to a Lambertian lobe of `diffuse`, at
  /// the cosines of BsdfForm::transmittance. nullptr if it is 1. Only control terms depend on it.
  std::shared_ptr<const std::array<float, BsdfForm::kTableSize>> probed;
  const float* transmittance() const {
    return is_described ? form.transmittance : probed ? probed->data() : nullptr;
  }
  /// Roughness of the glossy lobe, as the alpha of a GGX distribution of half vectors. Only
  /// importance depends on it.
  simd::HalfVectorLobe lobe{1, 1};
  float alpha2() const { return lobe.alpha_u * lobe.alpha_v; }

  // Results of the plan, for one primary:
  float uncertainty = 0;  ///< sum over strata of the weights by which rays are distributed
  float mean_sigma = 1;
};

/// Sine of a cone's half angle. 2 if the angle is 90 degrees or more: some normal of the cone then
/// faces any direction.
inline float cone_sine(float cosine) {
  return cosine > 0 ? safe_sqrt(1 - std::min(cosine * cosine, 1.f)) : 2.f;
}

inline bool is_microfacet(const BsdfForm& form) {
  return form.glossy == BsdfForm::Glossy::kBeckmann || form.glossy == BsdfForm::Glossy::kGgx;
}

/// Converts the kind of a form to the kernels' type.
inline simd::MicrofacetKind kind_of(const BsdfForm& form) {
  simd::MicrofacetKind kind;
  kind.is_ggx = form.glossy == BsdfForm::Glossy::kGgx;
  kind.is_conductor = form.is_conductor;
  for (int c = 0; c < 3; ++c) {
    kind.eta[c] = form.eta[c];
    kind.k[c] = form.k[c];
  }
  return kind;
}
inline simd::FirstMicrofacet microfacet_of(const BsdfForm& form) {
  return {form.alpha_u, form.alpha_v, {form.specular.x, form.specular.y, form.specular.z}};
}

/// True if the lobe is so sharp that points with different normals don't share directions.
inline bool is_sharp(const Patch& patch) {
  return patch.alpha2() < 0.01f && !any(patch.bsdf->lobes() & Lobe::kDiffuse);
}

/// Returns the roughness of the lobe of a form for which is_microfacet() is true.
simd::HalfVectorLobe microfacet_lobe(const BsdfForm& form);
/// Returns the roughness of the glossy lobe at a point. `form` is the point's form, if it has one.
simd::HalfVectorLobe glossy_lobe(const SurfaceInteraction& si, const std::optional<BsdfForm>& form);

/// Divides the points of a pilot's tile into patches.
void make_patches(TilePrimaries& primaries, std::vector<Patch>& patches);
/// Assigns the points of a later pass to the patches. Adds patches for points that fit none.
void assign_patches(TilePrimaries& primaries, std::vector<Patch>& patches);

}  // namespace kinome

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clustered/product/primaries.h"
#include "clustered/product/visibility.h"
#include "kinome/wide/bsdf.h"

namespace kinome {

/// A piece of surface of one material and nearly one normal, as a tile of pixels sees it: what
/// shares learned visibility and a list of cells.
struct Patch {
  const Bsdf* bsdf = nullptr;
  Vec3 normal{0, 0, 1};          ///< mean
  Vec3 position{0.f};            ///< mean
  Vec3 viewer{0, 0, 1};          ///< mean, unit
  float cone_cosine = 1;         ///< all normals are within
  float tolerance = 0;           ///< distance from the plane within which points belong here
  Rgb diffuse{0.f};              ///< mean
  float glossy_reflectance = 0;  ///< of the first point, mean of channels
  /// All points have a BsdfForm of the kind of `form`, by which kernels may evaluate them.
  bool is_described = false;
  BsdfForm form;
  bool is_uniform = false;  ///< and their glossy lobes are alike
  /// Of a diffuse lobe without a form: its value relative to a Lambertian one of `diffuse`, at
  /// cosines as in BsdfForm::transmittance; nullptr: 1. Only control terms depend on it.
  std::shared_ptr<const std::array<float, BsdfForm::kTableSize>> probed;
  const float* transmittance() const {
    return is_described ? form.transmittance : probed ? probed->data() : nullptr;
  }
  /// Width of the glossy lobe, as of a GGX distribution of half vectors. Only importance depends on
  /// it.
  simd::HalfVectorLobe lobe{1, 1};
  float alpha2() const { return lobe.alpha_u * lobe.alpha_v; }
  uint32_t count = 0;  ///< points of the pilot

  // What the plan found, of one primary:
  float uncertainty = 0;      ///< sum over strata of what rays are distributed by
  float glossy = 0;           ///< unshadowed glossy radiance
  float cell_share = 0.5f;    ///< of candidates that are drawn from the cells
  float mean_visibility = 1;  ///< of glossy light, and of local light but lamps
  float lamp_visibility = 1;
  float mean_sigma = 1;
  /// Rays that a primary's BSDF sends after local light, on average; at most 1.
  float eye_rays = 0.5f;
  bool trust = true;  ///< false: v is of no use to the glossy lobe
};

/// Sine of a cone's half angle; 2 where that is a right angle or more: whatever faces any normal
/// may face one of these.
inline float cone_sine(float cosine) {
  return cosine > 0 ? safe_sqrt(1 - std::min(cosine * cosine, 1.f)) : 2.f;
}

inline bool is_microfacet(const BsdfForm& form) {
  return form.glossy == BsdfForm::Glossy::kBeckmann || form.glossy == BsdfForm::Glossy::kGgx;
}

/// The same for kernels.
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

/// Reflects by a lobe so sharp that points of different normals share no directions.
inline bool is_sharp(const Patch& patch) {
  return patch.alpha2() < 0.01f && !any(patch.bsdf->lobes() & Lobe::kDiffuse);
}

/// True where the point may belong to the patch.
bool belongs(const Patch& patch, const Bsdf* bsdf, const Vec3& normal, const Vec3& position);

/// Width of the glossy lobe at a point, whose form is `form` if it has one.
simd::HalfVectorLobe glossy_lobe(const SurfaceInteraction& si, const std::optional<BsdfForm>& form);

/// Divides the points of a pilot's tile into patches.
void make_patches(TilePrimaries& primaries, std::vector<Patch>& patches);
/// Assigns the points of a later pass to the patches, making more where none fits.
void assign_patches(TilePrimaries& primaries, std::vector<Patch>& patches);

}  // namespace kinome

#pragma once

#include "clustered/product/tiles/groups.h"
#include "transport/blocks/arena.h"

namespace kinome {

/// Directions at members of a group, in world space. Arrays are padded to simd::kLobeLanes.
struct Directions {
  const uint32_t* member;
  const float *dx, *dy, *dz;
  size_t count;
};
/// BSDF x cosine for each direction, and the density of sampling it by the BSDF, per solid angle.
using LobeColumns = simd::MicrofacetValues;

/// Returns the fraction of a patch's BSDF samples that are drawn by the cosine. The rest are drawn
/// from the glossy lobe.
float diffuse_share(const Patch& patch);

/// wide::perturbed_normal_factor at a primary whose form has_perturbed_normal.
inline float perturbed_normal_factor_at(const TilePrimaries& primaries, uint32_t primary,
                                        const Vec3& d) {
  const simd::TurnedPoints& turned = primaries.turned();
  const auto i = static_cast<size_t>(primaries.point(primary));
  const float cosine =
      turned.normal[0][i] * d.x + turned.normal[1][i] * d.y + turned.normal[2][i] * d.z;
  return wide::perturbed_normal_factor(cosine, turned.bump_alpha2[i]);
}

/// Evaluates BSDFs for directions at members of a group. Uses kernels if the patch is_described,
/// else Bsdf::shade_block, which is slower. Reuses its memory; one per thread.
class LobeValues {
 public:
  LobeValues();

  /// Evaluates the glossy lobe. The density is that of simd::sample_lobe for the patch's lobe.
  void glossy(const GroupView& group, const Directions& directions, const LobeColumns& out);
  /// Evaluates all lobes except delta lobes. The density is that of the mixture of cosine and
  /// glossy lobe; see diffuse_share.
  void all(const GroupView& group, const Directions& directions, const LobeColumns& out);
  /// Evaluates f alone with Bsdf::shade_block. The arrays need no padding.
  void ask(const GroupView& group, Lobe lobes, const Directions& directions, float* const f[3]);

 private:
  void evaluate_with_density(const GroupView& group, Lobe lobes, const Directions& directions,
                             const LobeColumns& out);

  transport::Arena arena_;
  SurfaceBlock points_;  ///< copy of the surface point, for each direction
  Columns3 wo_;
  BsdfAnswer answer_;
};

}  // namespace kinome

#pragma once

#include "clustered/product/groups.h"
#include "transport/arena.h"

namespace kinome {

/// Directions at members of a group, world space; arrays padded to simd::kLobeLanes.
struct Directions {
  const uint32_t* member;
  const float *dx, *dy, *dz;
  size_t count;
};
/// What BSDFs say of each direction.
struct LobeColumns {
  float* f[3];     ///< BSDF x cosine
  float* density;  ///< by which rays are drawn from the BSDF, per solid angle
};

/// Of the rays that a patch's points send by their BSDFs, the share that goes by the cosine rather
/// than by the glossy lobe.
float diffuse_share(const Patch& patch);

/// wide::turned_factor at a primary whose form is_turned.
inline float turned_factor_at(const TilePrimaries& primaries, uint32_t primary, const Vec3& d) {
  const simd::TurnedPoints& turned = primaries.turned();
  const auto i = static_cast<size_t>(primaries.point(primary));
  const float cosine =
      turned.normal[0][i] * d.x + turned.normal[1][i] * d.y + turned.normal[2][i] * d.z;
  return wide::turned_factor(cosine, turned.bump_alpha2[i]);
}

/// Evaluates BSDFs for directions at members of a group: by kernels where the patch is_described,
/// elsewhere by asking them, which is slower. Keeps its memory: one per thread.
class LobeValues {
 public:
  LobeValues();

  /// Of the glossy lobe; density: that of the patch's lobe, simd::sample_lobe.
  void glossy(const GroupView& group, const Directions& directions, const LobeColumns& out);
  /// Of all lobes but delta; density: that of rays which go by the cosine or by the glossy lobe,
  /// see diffuse_share.
  void all(const GroupView& group, const Directions& directions, const LobeColumns& out);
  /// f cos alone, from the BSDFs. The arrays need no padding.
  void ask(const GroupView& group, Lobe lobes, const Directions& directions, float* const f[3]);

 private:
  void ask_with_density(const GroupView& group, Lobe lobes, const Directions& directions,
                        const LobeColumns& out);

  transport::Arena arena_;
  SurfaceBlock points_;  ///< where BSDFs are asked, one for each direction
  Columns3 wo_;
  BsdfAnswer answer_;
};

}  // namespace kinome

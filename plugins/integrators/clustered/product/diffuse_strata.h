#pragma once

#include <vector>

#include "clustered/product/groups.h"
#include "clustered/product/lobe_values.h"
#include "clustered/product/patch_cells.h"
#include "clustered/product/ray_comb.h"
#include "clustered/product/shadow_rays.h"

namespace kinome {

/// Distant light that diffuse lobes reflect: its strata are cells, whose unshadowed light is known
/// without rays. One per thread; not thread-safe. `light` must outlive it.
class DiffuseStrata {
 public:
  explicit DiffuseStrata(const CellLight& light) : light_(light), prepared_(light) {}

  /// Patches of another tile follow, so many. See PreparedPatches.
  void begin_tile(size_t patches, uint64_t seed) { prepared_.begin_tile(patches, seed); }
  void begin_unit() { mixed_visibility_.clear(); }

  /// False where there is no such light.
  bool applies(const GroupView& group) const;
  /// Appends the group's cells to the strata. Returns what learned visibilities say that its points
  /// reflect, summed.
  Rgb add(const GroupView& group, Strata& strata);
  /// Adds that value of the group that was added last to `sums`, each member's part to its own sum.
  void split(const GroupView& group, const UnitSums& sums) const;
  /// Makes shadow rays of the comb's hits on the segment that add() appended for the group, and
  /// takes what add() counted on from the sum of the answers. Members take turns from `turn` on, in
  /// units of 2^-32.
  void shoot(const GroupView& group, const SegmentHits& hits, uint32_t turn, const Answers& answers,
             ShadowRays& rays);

  /// What is expected of a patch's points, from learned visibilities.
  struct PatchPlan {
    float uncertainty = 0;  ///< sum of the strata of one point: the scale of its noise
    float control[9] = {};  ///< of the light that they see [channel x 3 + axis]
  };
  PatchPlan plan(const Patch& patch, const Visibility& visibility);

 private:
  /// Rays whose BSDFs have to be asked.
  struct Shots {
    std::vector<uint32_t> member, cell;
    std::vector<float> dx, dy, dz, f[3];
    std::vector<Rgb> weight;  ///< of f
    void clear();
    void push_back(uint32_t to_member, uint32_t to_cell, const Vec3& d, const Rgb& weight_of_f);
  };
  void ask_and_shoot(const GroupView& group, const Answers& answers, ShadowRays& rays);

  const CellLight& light_;
  PreparedPatches prepared_;
  std::vector<float> mixed_visibility_;  ///< see simd::diffuse_strata; of the unit's segments
  LobeValues values_;
  Shots shots_;
  float flux_[9] = {}, straddling_[3] = {};  ///< of the group added last: see simd::diffuse_strata
  PreparedPatch planned_;
  Strata planned_strata_;
};

}  // namespace kinome

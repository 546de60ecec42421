#pragma once

#include <vector>

#include "clustered/product/choice/candidates.h"
#include "clustered/product/choice/patch_cells.h"
#include "clustered/product/rays/ray_comb.h"
#include "clustered/product/rays/shadow_rays.h"
#include "clustered/product/tiles/groups.h"

namespace kinome {

/// Estimates the distant light that diffuse lobes reflect. Its strata are cells, whose unshadowed
/// light is known without rays. One per thread; not thread-safe. `light` must outlive it.
class DiffuseStrata {
 public:
  explicit DiffuseStrata(const CellLight& light) : light_(light), prepared_(light) {}

  /// Begins a tile with this number of patches. See PreparedPatches.
  void begin_tile(size_t patches, uint64_t seed) { prepared_.begin_tile(patches, seed); }
  void begin_unit() { mixed_visibility_.clear(); }

  /// False if the group reflects no such light.
  bool applies(const GroupView& group) const;
  /// Appends the group's cells to the strata. Returns their control terms, summed over the group's
  /// points.
  Rgb add(const GroupView& group, Strata& strata);
  /// Adds the control terms of the last add() to `sums`, each member's part to its own sum.
  void split(const GroupView& group, const UnitSums& sums) const;
  /// Makes shadow rays from the comb's hits on the segment that add() appended for the group, and
  /// subtracts their control terms from `answers.sums`. Members take turns as origins; the first is
  /// given by `turn`, in units of 2^-32 of the group.
  void shoot(const GroupView& group, const SegmentHits& hits, uint32_t turn, const Answers& answers,
             ShadowRays& rays);

  /// Forecast for the points of a patch, from learned visibilities.
  struct PatchPlan {
    float uncertainty = 0;  ///< total weight of the strata of one point: the scale of its noise
    float control[9] = {};  ///< vector flux of the visible light, [channel x 3 + axis]
  };
  PatchPlan plan(const Patch& patch, const Visibility& visibility);

 private:
  void evaluate_and_shoot(const GroupView& group, const Answers& answers, ShadowRays& rays);

  const CellLight& light_;
  PreparedPatches prepared_;
  std::vector<float> mixed_visibility_;  ///< for the unit's segments; see simd::diffuse_strata
  LobeValues values_;
  Candidates shots_;                         ///< rays for which Bsdf::shade_block must be called
  float flux_[9] = {}, straddling_[3] = {};  ///< for the last group; see simd::diffuse_strata
  PreparedPatch planned_;
  Strata planned_strata_;
};

}  // namespace kinome

#pragma once

#include <span>
#include <vector>

#include "clustered/product/candidates.h"
#include "clustered/product/cell_light.h"
#include "clustered/product/local_choice.h"
#include "clustered/product/ray_comb.h"
#include "clustered/product/shadow_rays.h"

namespace kinome {

/// Local light that diffuse and glossy lobes reflect: each point connects to some of the light
/// points that its tile has chosen, and to its lamps; these connections are the strata. What rays
/// sent by the BSDF (EyeRays) find as well shares its light with them, by the balance heuristic.
/// One per thread; not thread-safe. `light`, which has local light, and `choice` must outlive it.
class LocalStrata {
 public:
  LocalStrata(const CellLight& light, const LocalChoice& choice) : light_(light), choice_(choice) {}

  void begin_unit() { candidates_.resize(0); }
  /// False where there is nothing to reflect it.
  static bool applies(const GroupView& group) { return group.has(Lobe::kDiffuse | Lobe::kGlossy); }

  /// Random numbers of a unit: a primary's block of light points is that of `block` + its number.
  struct Numbers {
    uint32_t block;
    uint64_t lamps;
  };
  /// Connects the group's points and appends the connections to the strata. eye_rays: rays that
  /// each point sends by its BSDF, on average. Returns what learned visibilities say that the
  /// points reflect, summed.
  Rgb add(const GroupView& group, float eye_rays, const Numbers& numbers, Strata& strata);
  /// Adds the value that the last add() for the group returned, `control`, to `sums`, each member's
  /// part to its own sum.
  void split(const GroupView& group, const Rgb& control, const UnitSums& sums) const {
    split_control(group, candidates_, first_, control, sums);
  }
  /// For the plan, from the connections that were added last, if there are any: adds mean and
  /// variance of the unshadowed light to the group's `points` (of the tile) and to `patch`, and how
  /// many eye rays are called for.
  void plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const;
  /// Makes shadow rays of the comb's hits on the segment that add() appended for the group, and
  /// subtracts the control terms of these from the sum of the answers.
  void shoot(const GroupView& group, const SegmentHits& hits, const Answers& answers,
             ShadowRays& rays) const;

 private:
  struct Columns : Candidates {
    std::vector<uint32_t> point;   ///< of LocalPoints, or LightPoint::kLambertian: a lamp
    std::vector<float> distance;   ///< to the light
    std::vector<float> eye_ratio;  ///< ConnectionColumns::eye_ratio
    void resize(size_t size);
  };
  void connect_points(const GroupView& group, uint32_t first_block);
  void connect_lamps(const GroupView& group, const Numbers& numbers);
  void pad(const GroupView& group);
  void add_reflections(const LocalChoice::Block& block, size_t first);
  const LightPoint* point_of(size_t candidate) const;
  uint32_t max_passes(uint32_t point) const;

  const CellLight& light_;
  const LocalChoice& choice_;
  LobeValues values_;
  Columns candidates_;
  size_t first_ = 0, end_points_ = 0;  ///< of those added last; lamps are from end_points_ on
};

}  // namespace kinome

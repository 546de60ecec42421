#pragma once

#include <span>
#include <vector>

#include "clustered/product/choice/candidates.h"
#include "clustered/product/choice/cell_light.h"
#include "clustered/product/choice/local_choice.h"
#include "clustered/product/rays/ray_comb.h"
#include "clustered/product/rays/shadow_rays.h"

namespace kinome {

/// Estimates the local light that diffuse and glossy lobes reflect. Each surface point connects to
/// one block of the light points that its tile has selected, and to a block of lamps. These
/// connections are the strata. The balance heuristic divides light that eye rays find as well. One
/// per thread; not thread-safe. `light` must have local light; `light` and `choice` must outlive
/// it.
class LocalStrata {
 public:
  LocalStrata(const CellLight& light, const LocalChoice& choice) : light_(light), choice_(choice) {}

  void begin_unit() { candidates_.resize(0); }
  /// False if the BSDF has neither a diffuse nor a glossy lobe.
  static bool applies(const GroupView& group) { return group.has(Lobe::kDiffuse | Lobe::kGlossy); }

  /// Random numbers of a unit.
  struct Numbers {
    uint32_t block;  ///< primary i uses block `block` + i of the light points
    uint64_t lamps;  ///< seed for lamps
  };
  /// Connects the group's points and appends the connections to the strata. `eye_rays` is the
  /// expected number of eye rays of each point. Returns the control terms, summed over the points.
  Rgb add(const GroupView& group, float eye_rays, const Numbers& numbers, Strata& strata);
  /// See split_control(). `control` is the result of the last add() for the group. Divides the
  /// term among light groups, too.
  void split(const GroupView& group, const Rgb& control, const UnitSums& sums) const;
  /// Computes the plan's input from the connections of the last add(), if any: mean and variance of
  /// the unshadowed light, and the number of eye rays. Adds them to the group's points in `points`
  /// (all points of the tile) and to `patch`.
  void plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const;
  /// See DiffuseStrata::shoot().
  void shoot(const GroupView& group, const SegmentHits& hits, const Answers& answers,
             ShadowRays& rays) const;

 private:
  struct Columns : Candidates {
    std::vector<uint32_t> point;   ///< index in LocalPoints; LightPoint::kLambertian for a lamp
    std::vector<float> distance;   ///< to the light point or lamp
    std::vector<float> eye_ratio;  ///< ConnectionColumns::eye_ratio
    std::vector<uint8_t> group;    ///< light group; only if light is divided
    void resize(size_t size);
    void add_lamp(uint32_t of_member, uint32_t of_cell, const Vec3& d, float far, const Rgb& light,
                  uint32_t of_group = 0);
  };
  void connect_points(const GroupView& group, uint32_t first_block);
  void connect_lamps(const GroupView& group, const Numbers& numbers);
  void add_reflections(const LocalChoice::Block& block, size_t first);
  const LightPoint* point_of(size_t candidate) const;
  uint32_t max_passes(uint32_t point) const;
  /// Sums of the light group of a candidate.
  UnitSums of_candidate(const UnitSums& sums, size_t candidate) const {
    return light_.groups ? sums.of_group(candidates_.group[candidate]) : sums;
  }

  const CellLight& light_;
  const LocalChoice& choice_;
  LobeValues values_;
  Columns candidates_;
  /// Candidates of the last add(): light points are [first_, end_points_), lamps follow.
  size_t first_ = 0, end_points_ = 0;
};

}  // namespace kinome

#pragma once

#include <span>
#include <vector>

#include "clustered/product/choice/candidates.h"
#include "clustered/product/choice/cell_importance.h"
#include "clustered/product/rays/ray_comb.h"
#include "clustered/product/choice/shared_candidates.h"
#include "clustered/product/rays/shadow_rays.h"

namespace kinome {

/// Estimates the distant light that glossy lobes reflect, from many unshadowed candidates. Some are
/// drawn from the lobe, others from the cells by CellImportance; the balance heuristic weights
/// both. The candidates are the strata. One per thread; not thread-safe. `light` must outlive it.
class GlossyStrata {
 public:
  explicit GlossyStrata(const CellLight& light);

  /// Numbers of candidates of a group.
  struct Counts {
    uint32_t lobe_log2;  ///< log2 of the number from the lobe
    uint32_t from_cells;
  };
  /// Divides about `candidates` candidates between lobe and cells by the patch's cell_share.
  static Counts counts(const Patch& patch, float candidates);
  /// Returns the counts for a group of the pilot, enough to estimate variances.
  static Counts pilot_counts(const Patch& patch);

  /// See SharedCandidates. Nothing is shared before the first begin_tile().
  void begin_tile(const TilePrimaries& primaries, std::span<const Patch> patches,
                  std::span<const Visibility> visibility, std::span<const Unit> units,
                  uint64_t seed) {
    shared_.begin_tile(primaries, patches, visibility, units, seed);
  }
  void begin_unit() { candidates_.resize(0); }
  /// False if the group reflects no such light.
  bool applies(const GroupView& group) const {
    return light_.has_distant() && group.has(Lobe::kGlossy);
  }
  /// Appends about `candidates` candidates to the strata, shared ones if the group may share.
  /// Returns their control terms, summed over the group's points.
  Rgb add(const GroupView& group, float candidates, uint64_t seed, Strata& strata);
  /// Does the same without shared candidates.
  Rgb add(const GroupView& group, const Counts& counts, uint64_t seed, Strata& strata);
  /// See split_control(). `control` is the result of the last add() for the group.
  void split(const GroupView& group, const Rgb& control, const UnitSums& sums) const {
    split_control(group, candidates_, first_, control, sums);
  }
  /// Computes the plan's input from the candidates of the last add(). Sets mean and variance of the
  /// unshadowed light of the group's points; `points` has all points of the tile. Adds the group's
  /// part of the mean to `patch`, and of the share of candidates from the cells that minimises the
  /// second moment.
  void plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const;
  /// See DiffuseStrata::shoot().
  void shoot(const GroupView& group, const SegmentHits& hits, const Answers& answers,
             ShadowRays& rays) const;

 private:
  /// Numbers of candidates of the last add() that shared none.
  struct Drawn {
    uint32_t from_lobe = 0, from_cells = 0;
  };
  void draw_from_lobe(const GroupView& group, uint32_t lobe_log2, uint64_t seed);
  void draw_from_cells(const GroupView& group, size_t first, uint32_t count, uint64_t seed);

  Rgb take(const GroupView& group, const SharedCandidates::Set& set, uint32_t blocks,
           uint64_t seed, Strata& strata);

  const CellLight& light_;
  LobeValues values_;
  SharedCandidates shared_;
  DistantCandidates candidates_;
  size_t first_ = 0;  ///< index of the first candidate of the last add()
  Drawn drawn_;
  CellImportance importance_;  ///< for the group drawn last
};

}  // namespace kinome

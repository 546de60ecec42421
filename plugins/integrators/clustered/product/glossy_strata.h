#pragma once

#include <span>
#include <vector>

#include "clustered/product/candidates.h"
#include "clustered/product/cell_importance.h"
#include "clustered/product/ray_comb.h"
#include "clustered/product/shared_candidates.h"
#include "clustered/product/shadow_rays.h"

namespace kinome {

/// Distant light that glossy lobes reflect, estimated from many unshadowed candidates: directions
/// drawn from the lobe, and from the cells by what the lobe may show of them, weighed by the
/// balance heuristic. Its strata are the candidates. One per thread; not thread-safe. `light` must
/// outlive it.
class GlossyStrata {
 public:
  explicit GlossyStrata(const CellLight& light);

  /// Candidates of a group.
  struct Counts {
    uint32_t lobe_log2;
    uint32_t from_cells;
  };
  /// About so many in all, by the patch's cell_share.
  static Counts counts(const Patch& patch, float candidates);
  /// Of a pilot's group: enough to tell variances.
  static Counts pilot_counts(const Patch& patch);

  /// See SharedCandidates. Where none has begun, or after share_nothing(), nothing is shared.
  void begin_tile(const TilePrimaries& primaries, std::span<const Patch> patches,
                  std::span<const Visibility> visibility, std::span<const Unit> units,
                  uint64_t seed) {
    shared_.begin_tile(primaries, patches, visibility, units, seed);
  }
  void share_nothing() { shared_.clear(); }
  void begin_unit() { candidates_.resize(0); }
  /// False where there is no such light.
  bool applies(const GroupView& group) const {
    return light_.has_distant() && group.has(Lobe::kGlossy);
  }
  /// About so many candidates, shared ones where the group may share, appended to the strata.
  /// Returns what learned visibilities say that its points reflect, summed.
  Rgb add(const GroupView& group, float candidates, uint64_t seed, Strata& strata);
  /// The same with candidates of the group's own.
  Rgb add(const GroupView& group, const Counts& counts, uint64_t seed, Strata& strata);
  /// Adds the value that the last add() for the group returned, `control`, to `sums`, each member's
  /// part to its own sum.
  void split(const GroupView& group, const Rgb& control, const UnitSums& sums) const {
    split_control(group, candidates_, first_, control, sums);
  }
  /// For the plan, from the candidates that were added last: mean and variance of the unshadowed
  /// light of the group's `points` (of the tile), which is also added to `patch`, and the share of
  /// candidates from the cells that would have had the least second moment.
  void plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const;
  /// Makes shadow rays of the comb's hits on the segment that add() appended for the group, and
  /// takes what add() counted on from the sum of the answers.
  void shoot(const GroupView& group, const SegmentHits& hits, const Answers& answers,
             ShadowRays& rays) const;

 private:
  /// The candidates that were added last.
  struct Drawn {
    size_t first = 0;
    uint32_t from_lobe = 0, from_cells = 0;
  };
  void draw(const GroupView& group, const Counts& counts, uint64_t seed);
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

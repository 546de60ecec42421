#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clustered/product/choice/cell_light.h"
#include "clustered/product/strata/diffuse_strata.h"
#include "clustered/product/paths/eye_rays.h"
#include "clustered/product/strata/glossy_strata.h"
#include "clustered/product/tiles/groups.h"
#include "clustered/product/choice/local_choice.h"
#include "clustered/product/strata/local_strata.h"
#include "clustered/product/tiles/patches.h"
#include "clustered/product/rays/ray_comb.h"
#include "clustered/product/rays/shadow_rays.h"
#include "clustered/product/tiles/stage_times.h"
#include "clustered/product/tiles/unit.h"

namespace kinome {

/// Estimates the light that surface points reflect from cells of distant and local light:
///
///     sum over cells of v_c A_c + (1 / n) sum over rays of (f V - v_c A_c q_c) / (P_c q_c)
///
/// A_c is the unshadowed reflected light of cell c, v_c its learned visibility, and q_c the density
/// within the cell (see PRODUCT.md). For diffuse light, A_c is known without rays. For glossy and
/// local light, it is estimated from many candidates; those of local light are selected points of
/// the pass. A few rays sampled by the BSDF (eye rays) find part of the local light as well;
/// balance weights divide it between the two. Shadow rays correct the control terms. One comb
/// distributes them over all points of a unit to where visibility is uncertain: P_c ~ A_c sigma_c.
///
/// The stages run in this order. Each is a class with its own buffers:
///
///     Groups         divides a unit's points into groups that share strata
///     DiffuseStrata, GlossyStrata, LocalStrata
///                    add strata and control terms of each group
///     SharedCandidates
///                    provides directions to GlossyStrata for pixels that reflect alike
///     RayComb        selects the strata that get shadow rays; DiffuseStrata etc. make the rays
///     EyeRays        sends rays sampled by BSDFs, and adds the light that they find
///     ShadowRays     collects and traces shadow rays, and adds the results
///
/// Unbiased for any v, sigma and patches that were fixed before the rays were drawn. One per
/// thread; not thread-safe.
class Estimator {
 public:
  explicit Estimator(const CellLight& light);

  /// Begins the tile of the next units. Primaries, patches and the `visibility` of each patch must
  /// not change before the tile's last unit. `units` are those that may share candidates, in any
  /// order.
  void begin_tile(const Scene& scene, const TilePrimaries& primaries, std::span<Patch> patches,
                  std::span<const Visibility> visibility, uint64_t seed, RenderCounters& counters,
                  std::span<const Unit> units = {});

  /// Adds the reflected light of the unit's points to `sums`: control terms immediately, results of
  /// rays after they are traced. The sums must not move before flush().
  void estimate(const Unit& unit, const UnitSums& sums);

  /// Traces the unit's shadow rays for the pilot, without an estimate. Appends their visibilities
  /// to the `records` of each patch. Also stores the plan's input in the patches and in `points`
  /// (one per primary of the tile). `points` and `records` must not move before flush(). The time
  /// isn't added to any stage until the next begin_tile(), because all stages belong to the main
  /// pass.
  void probe(const Unit& unit, std::span<PointPlan> points,
             std::span<std::vector<VisibilityRecord>> records);
  /// Traces all waiting rays.
  void flush();

 private:
  bool has_local() const { return light_.local != nullptr; }
  GroupView view(uint32_t group) const {
    return groups_.view(group, patches_, visibility_, *primaries_);
  }
  void add_diffuse(const GroupView& group, const UnitSums& sums);
  void add_glossy(const GroupView& group, const Unit& unit, const UnitSums& sums,
                  std::span<PointPlan> points);
  void add_local(const GroupView& group, const Unit& unit, const UnitSums& sums,
                 std::span<PointPlan> points);
  void add_strata(const Unit& unit, const UnitSums& sums, std::span<PointPlan> points);
  void shoot(const Unit& unit, const Answers& answers);
  template <class Function>
  void for_each_mirroring(const Function& fn) const;
  void send_eye_rays(const Unit& unit, const UnitSums& sums);
  void shoot_mirrored(uint64_t seed, const UnitSums& sums);
  template <class SumOf>
  void follow_paths(const Unit& unit, const SumOf& sum_of);

  const CellLight& light_;
  const Scene* scene_ = nullptr;
  RenderCounters* counters_ = nullptr;
  const TilePrimaries* primaries_ = nullptr;
  std::span<Patch> patches_;
  std::span<const Visibility> visibility_;

  StageTimes times_;
  LocalChoice choice_;
  Groups groups_;
  Strata strata_;
  DiffuseStrata diffuse_;
  GlossyStrata glossy_;
  LocalStrata local_;
  RayComb comb_;
  EyeRays eye_rays_;
  std::optional<EyePaths> paths_;  ///< for primaries that continue as paths
  ShadowRays shadow_rays_;
};

}  // namespace kinome

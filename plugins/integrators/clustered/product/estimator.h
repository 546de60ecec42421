#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clustered/product/cell_light.h"
#include "clustered/product/diffuse_strata.h"
#include "clustered/product/eye_rays.h"
#include "clustered/product/glossy_strata.h"
#include "clustered/product/groups.h"
#include "clustered/product/local_choice.h"
#include "clustered/product/local_strata.h"
#include "clustered/product/patches.h"
#include "clustered/product/ray_comb.h"
#include "clustered/product/shadow_rays.h"
#include "clustered/product/stage_times.h"
#include "clustered/product/unit.h"

namespace kinome {

/// Estimates the light that surface points reflect from cells of distant and local light, by
///
///     sum over cells of v_c A_c + (1 / n) sum over rays of (f V - v_c A_c q_c) / (P_c q_c)
///
/// A_c is the unshadowed reflected light of cell c, v_c a visibility that was learned earlier, q_c
/// the density within the cell. Of diffuse light A_c is known without rays; of glossy light it is
/// estimated by many unshadowed candidates, and so is that of local light, whose candidates are a
/// choice of the pass's points. What rays of the BSDF would find as well shares its light with
/// them, and is found by a few of these (eye rays). Shadow rays correct the control terms, and go
/// where the visibility is uncertain: P_c ~ A_c sigma_c, by one comb for all points of a unit.
///
/// Here is which stages do that, and in which order; each is a class of its own, which keeps its
/// buffers and is told what it needs of the others':
///
///     Groups         a unit's points, divided into those that share strata
///     DiffuseStrata, GlossyStrata, LocalStrata
///                    of each group, strata and control terms
///     SharedCandidates
///                    directions that GlossyStrata takes for pixels that reflect alike
///     RayComb        strata that get the shadow rays, which the three make of its hits
///     EyeRays        rays by BSDFs, and what they find
///     ShadowRays     rays that wait, and what their answers go to
///
/// Unbiased whatever v, sigma and the patches are, as long as they were fixed before the rays were
/// drawn. One per thread; not thread-safe.
class Estimator {
 public:
  explicit Estimator(const CellLight& light);

  /// The tile whose units follow; primaries, patches and the `visibility` of each patch must stay
  /// as they are until the last of them. A patch's visibility is asked for when the first unit
  /// needs it. `units`: those that may share candidates, in any order.
  void begin_tile(const Scene& scene, const TilePrimaries& primaries, std::span<Patch> patches,
                  std::span<const Visibility> visibility, uint64_t seed, RenderCounters& counters,
                  std::span<const Unit> units = {});

  /// Adds the reflected light of the unit's points to `sums`: control terms at once, results of rays
  /// when they are traced. The sums must stay where they are until flush().
  void estimate(const Unit& unit, const UnitSums& sums);

  /// The same without an estimate: rays find out visibilities, and what they find is kept for each
  /// patch, with what the plan needs to know of patches and points (PointPlan, of each primary of
  /// the tile). All must stay where they are until flush(). Its time is counted to no stage until
  /// the next begin_tile(): all stages here are parts of the main pass.
  void probe(const Unit& unit, std::span<PointPlan> points,
             std::span<std::vector<VisibilityRecord>> records);
  /// Traces the rays that wait.
  void flush();

 private:
  bool has_local() const { return light_.local != nullptr; }
  GroupView view(uint32_t group) const;
  void begin_unit(const Unit& unit);
  void add_diffuse(const GroupView& group, const UnitSums& sums);
  void add_glossy(const GroupView& group, const Unit& unit, const UnitSums& sums);
  void probe_glossy(const GroupView& group, const Unit& unit, std::span<PointPlan> points);
  void add_local(const GroupView& group, const Unit& unit, float eye_rays, const UnitSums& sums,
                 std::span<PointPlan> points);
  float eye_rays_of(const GroupView& group, const Answers& answers) const;
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
  std::optional<EyePaths> paths_;  ///< of primaries, where a surface asks for them
  ShadowRays shadow_rays_;
};

}  // namespace kinome

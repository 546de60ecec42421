#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "clustered/product/point_plan.h"
#include "clustered/product/stage_times.h"
#include "clustered/product/straight_rays.h"
#include "clustered/product/unit.h"
#include "clustered/product/visibility.h"
#include "kinome/scene.h"

namespace kinome {

/// Destinations of the results of a unit's shadow rays: sums in an estimate, records of the patches
/// in a pilot. Must stay where they are until the rays are traced.
struct Answers {
  UnitSums sums;  ///< of visible light; control terms of the rays are subtracted from them
  std::vector<VisibilityRecord>* records = nullptr;  ///< of each patch
  PointPlan* points = nullptr;                       ///< of each primary, beside `records`
};

/// Shadow rays that wait for their answers, traced in batches, the last ones by trace(). One per
/// thread; not thread-safe.
class ShadowRays {
 public:
  /// `passing`: the scene, if rays pass surfaces straight that let them (Lobe::kNull), at most
  /// `max_passes`; nullptr: all surfaces stop them.
  explicit ShadowRays(StageTimes& times, const transport::SceneTable* passing = nullptr,
                      uint32_t max_passes = 0);

  /// The scene of all rays to come. They are counted, when they are traced, to the counters that
  /// came last.
  void begin(const Scene& scene, RenderCounters& counters) {
    scene_ = &scene;
    counters_ = &counters;
  }

  /// The light that a ray may find.
  struct Light {
    Rgb weight;            ///< added to the sum of the primary
    uint32_t cell;         ///< of a record
    int32_t patch;         ///< of records
    uint32_t primary = 0;  ///< start of the ray
    /// Surfaces that the ray passes straight, at most, if this is less than for all.
    uint32_t max_passes = ~0u;
  };
  /// What else a record's ray adds where it sees light; nothing, of most.
  struct Lit {
    float* sum = nullptr;
    float radiance = 0;
  };

  /// A ray from a surface to infinity. Rays whose weight is black are skipped.
  void push(const SurfaceInteraction& from, const Vec3& d, const Light& light,
            const Answers& answers) {
    if (skips(light)) return;
    put(from.ray_origin(d), d, kInfinity);
    wait(light, answers, {});
  }
  /// A ray from a surface to light at a distance, which may be infinite.
  void push(const SurfaceInteraction& from, const Vec3& d, float distance, const Light& light,
            const Answers& answers, const Lit& lit) {
    if (skips(light)) return;
    const ShadowRayOf<Vec3, float> ray(from.p, from.n, from.p_error, d, distance,
                                       distance < kInfinity);
    put(ray.o, ray.d, ray.tmax);
    wait(light, answers, lit);
  }

  /// Traces the rays that wait, and gives the answers away in their order.
  void trace();

 private:
  struct Pending {
    Rgb weight;
    uint32_t cell;
    uint32_t max_passes;
    Rgb* sum;
    std::vector<VisibilityRecord>* records;
  };
  bool skips(const Light& light) {
    if (!is_black(light.weight)) return false;
    ++counters_->skipped_shadow_rays;
    return true;
  }
  /// Number by number, where it waits: to copy a ray that has just been made takes longer than to
  /// make it.
  void put(const Vec3& o, const Vec3& d, float tmax) {
    Ray& ray = rays_[waiting_];
    ray.o = o;
    ray.d = d;
    ray.tmin = 0;
    ray.tmax = tmax;
  }
  void wait(const Light& light, const Answers& answers, const Lit& lit) {
    Pending& pending = pending_[waiting_];
    pending.weight = light.weight;
    pending.cell = light.cell;
    pending.max_passes = light.max_passes;
    pending.sum = answers.sums ? &answers.sums.of(light.primary) : nullptr;
    pending.records = nullptr;
    if (answers.records) {
      pending.records = &answers.records[light.patch];
      lit_[waiting_] = lit;
    }
    if (++waiting_ == rays_.size()) trace();
  }

  void trace_straight();
  void answer(size_t i, bool visible, const Rgb& transmittance);

  const Scene* scene_ = nullptr;
  RenderCounters* counters_ = nullptr;
  StageTimes& times_;
  std::optional<StraightRays> straight_;  ///< if they pass surfaces
  const uint32_t max_passes_;
  std::vector<Ray> rays_;  ///< those that wait are the first waiting_
  std::vector<Pending> pending_;
  std::vector<Lit> lit_;  ///< of those that wait for records
  size_t waiting_ = 0;
};

}  // namespace kinome

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "clustered/product/tiles/stage_times.h"
#include "clustered/product/rays/straight_rays.h"
#include "clustered/product/tiles/unit.h"
#include "clustered/product/tiles/visibility.h"
#include "kinome/scene.h"

namespace kinome {

/// Results of the pilot for one of its primaries, used by the plan. Values are radiances.
struct PointPlan {
  /// Unshadowed radiance that the primary's group reflects: by glossy lobes, and by all lobes for
  /// local light except that of lamps.
  float glossy = 0;
  float lamps = 0;  ///< unshadowed radiance of the primary, from lamps that got no ray
  /// Receives the radiance that arrives from the other lamps, when their rays are traced; may be
  /// nullptr.
  float* lit = nullptr;
  /// Receives the light that the primary's path finds, if one continues from it
  /// (Estimator::follow_paths).
  Rgb* followed = nullptr;
  double glossy_variance = 0;  ///< of one candidate; bright light would overflow a float
  float mirrored = 0;          ///< unshadowed radiance that delta lobes reflect
};

/// Destinations of the results of a unit's shadow rays: sums of an estimate, or records of the
/// patches in a pilot. They must stay valid and in place until the rays are traced.
struct Answers {
  UnitSums sums;  ///< of visible light; the control terms of rays are subtracted from them
  std::vector<VisibilityRecord>* records = nullptr;  ///< of each patch
  PointPlan* points = nullptr;                       ///< for each primary; used with `records`
};

/// Queue of shadow rays, which are traced in batches. Call trace() for the last ones. One object
/// per thread; not thread-safe.
class ShadowRays {
 public:
  /// `passing` is the scene if rays pass surfaces straight that let them (Lobe::kNull), at most
  /// `max_passes`. If it is nullptr, all surfaces block rays.
  explicit ShadowRays(StageTimes& times, const transport::SceneTable* passing = nullptr,
                      uint32_t max_passes = 0);

  /// Sets the scene of the next rays. Rays are counted in the counters that were set last before
  /// they are traced.
  void begin(const Scene& scene, RenderCounters& counters) {
    scene_ = &scene;
    counters_ = &counters;
  }

  /// The light that a ray tests.
  struct Light {
    Rgb weight;            ///< added to the sum of the primary
    uint32_t cell;         ///< cell of the record
    int32_t patch;         ///< patch of the records
    uint32_t primary = 0;  ///< origin of the ray
    /// Maximum number of surfaces that the ray passes straight, if that is less than the common
    /// maximum.
    uint32_t max_passes = ~0u;
  };
  /// Radiance that a recorded ray also adds to a sum if it sees light. `sum` is nullptr for most
  /// rays.
  struct Lit {
    float* sum = nullptr;
    float radiance = 0;
  };

  /// Adds a ray from a surface to infinity. Skips the ray if its weight is black.
  void push(const SurfaceInteraction& from, const Vec3& d, const Light& light,
            const Answers& answers) {
    if (skips(light)) return;
    put(from.ray_origin(d), d, kInfinity);
    wait(light, answers, {});
  }
  /// Adds a ray from a surface to light at a distance, which may be infinite.
  void push(const SurfaceInteraction& from, const Vec3& d, float distance, const Light& light,
            const Answers& answers, const Lit& lit) {
    if (skips(light)) return;
    const ShadowRayOf<Vec3, float> ray(from.p, from.n, from.p_error, d, distance,
                                       distance < kInfinity);
    put(ray.o, ray.d, ray.tmax);
    wait(light, answers, lit);
  }

  /// Traces the waiting rays and delivers the results in their order.
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
  /// Writes the fields of the next ray in place. Copying a ray that was just made takes longer than
  /// making it.
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
  std::optional<StraightRays> straight_;  ///< if rays pass surfaces straight
  const uint32_t max_passes_;
  std::vector<Ray> rays_;  ///< the first waiting_ rays wait
  std::vector<Pending> pending_;
  std::vector<Lit> lit_;  ///< of waiting rays with records
  size_t waiting_ = 0;
};

}  // namespace kinome

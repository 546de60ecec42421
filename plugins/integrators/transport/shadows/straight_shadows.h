#pragma once

#include "kinome/stats.h"
#include "transport/shadows/occlusion.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Traces the shadow rays of a block through surfaces that pass light straight (Lobe::kNull),
/// sorted by direction. All other surfaces stop them. Not thread-safe: use one per thread.
class StraightShadows {
 public:
  /// Allocates memory for the rays of at most `points` points, of which at most `rays` are active.
  StraightShadows(const SceneTable& scene, size_t points, size_t rays);

  /// Traces the first `count` rays. Active rays must have unit directions. `max_passes` is the
  /// maximum number of surfaces that each ray passes. Segments after the first count as further
  /// shadow rays.
  void trace(const Ray16* rays, size_t count, const float* max_passes, RenderCounters& counters);

  /// Product of the transmittances along each ray of the last trace(); 0 if the ray is inactive or
  /// stopped.
  const Columns3& transmittance() const { return transmittance_; }
  /// For each unoccluded ray, probability() is the product of the probabilities that BSDF samples
  /// go straight through the surfaces, and passes() is the number of surfaces.
  const float* probability() const { return probability_; }
  const float* passes() const { return passes_; }

 private:
  /// Rays that have neither arrived nor been stopped yet.
  struct Wave {
    uint32_t* from;  ///< index of the ray in trace()
    Columns3 transmittance;
    float* probability;
  };

  size_t begin(const Ray16* rays, size_t count);
  void arrive(const Wave& wave, float passes);
  size_t pass(const Ray16* rays, const float* max_passes, float passes, const Wave& wave,
              const Wave& next);

  const SceneTable& scene_;
  DirectionSort sort_;
  Surfaces met_;
  Arena per_point_, per_ray_, per_met_;
  Columns3 transmittance_;
  float *probability_, *passes_;
  RayHit16* rays_;  ///< rays of the current wave
  Wave waves_[2];
  NullTransmissionBlock through_;
};

}  // namespace kinome::transport

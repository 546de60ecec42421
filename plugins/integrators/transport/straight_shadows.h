#pragma once

#include "kinome/stats.h"
#include "occlusion.h"
#include "surfaces.h"

namespace kinome::transport {

/// Traces the shadow rays of a block through surfaces that pass light straight (Lobe::kNull), in
/// the order of their directions. All other surfaces stop them. One per thread.
class StraightShadows {
 public:
  /// For rays of at most `points` points, of which no more than `rays` are on.
  StraightShadows(const SceneTable& scene, size_t points, size_t rays);

  /// Traces the first `count` rays. Rays that are on must have unit directions. `max_passes` is the
  /// maximum number of surfaces that each ray passes. Segments behind the first count as shadow rays.
  void trace(const Ray16* rays, size_t count, const float* max_passes, RenderCounters& counters);

  /// Of each ray of the last trace(): the product of transmittances along it; 0 if it is off or
  /// stopped.
  const Columns3& transmittance() const { return transmittance_; }
  /// Of each ray that arrives: the product of the probabilities of BSDF samples to go straight
  /// through the surfaces, and the number of surfaces.
  const float* probability() const { return probability_; }
  const float* passes() const { return passes_; }

 private:
  /// Rays that have not arrived yet, without those that have been stopped.
  struct Wave {
    uint32_t* from;  ///< number of the ray
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
  RayHit16* rays_;  ///< of the wave
  Wave waves_[2];
  NullTransmissionBlock through_;
};

}  // namespace kinome::transport

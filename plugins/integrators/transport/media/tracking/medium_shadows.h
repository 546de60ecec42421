#pragma once

#include "kinome/stats.h"
#include "transport/media/tracking/random_seeds.h"
#include "transport/media/tracking/tracking.h"
#include "transport/shadows/direction_sort.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Traces the shadow rays of a block through media, and through surfaces that light passes straight
/// (Lobe::kNull), sorted by direction. All other surfaces stop them. Not thread-safe: use one per
/// thread.
class MediumShadows {
 public:
  /// Allocates memory for the rays of at most `points` points, of which at most `rays` are active.
  MediumShadows(const SceneTable& scene, const MediaTable& media, size_t points, size_t rays);

  /// Traces the first `count` rays. Active rays must have unit directions. `medium` has the number
  /// of the medium at each origin. `distance` has the length of each ray, infinite for distant
  /// light; tmax of the rays is slightly shorter. `owner` has the sample of each ray, for `seeds`.
  void trace(const Ray16* rays, size_t count, const uint32_t* medium, const float* distance,
             const uint32_t* owner, const RandomSeeds& seeds, RenderCounters& counters);

  /// Transmittance of media and surfaces along each ray of the last trace(); 0 if the ray is
  /// inactive or stopped.
  const Columns3& transmittance() const { return transmittance_; }

 private:
  /// Rays that have neither arrived nor been stopped yet.
  struct Wave {
    uint32_t* from;  ///< index of the ray in trace()
    uint32_t* medium;
    float* left;  ///< remaining distance to the light
    float* end;   ///< tmax of the ray
    Columns3 transmittance;
  };
  static Wave make_wave(Arena& arena);

  size_t begin(const Ray16* rays, size_t count, const uint32_t* medium, const float* distance);
  void travel(const Wave& wave, size_t count, const RayHit16* rays) const;
  void track(size_t leg, const uint32_t* owner, const RandomSeeds& seeds);
  size_t pass(size_t leg);

  const SceneTable& scene_;
  const MediaTable& media_;
  DirectionSort sort_;
  Surfaces met_;
  Arena per_point_, per_ray_, per_met_;
  Columns3 transmittance_;
  RayHit16* rays_[2];  ///< rays of the current wave and of the next
  Wave waves_[2];
  NullTransmissionBlock through_;
  Tracking tracking_;
};

}  // namespace kinome::transport

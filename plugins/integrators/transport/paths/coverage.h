#pragma once

#include "kinome/stats.h"
#include "transport/blocks/numbers.h"
#include "transport/camera/camera.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/scene_table.h"
#include "transport/surfaces/shading.h"

namespace kinome::transport {

/// True if an environment is hidden from the camera, both directly and behind masks and panes.
inline bool hides_environment(const PathSettings& settings, const Scene& scene) {
  return settings.hide_emitters && scene.environment();
}

/// Alpha of camera rays, as Mitsuba's `path` defines it. It is 1 for rays that see an environment
/// that isn't hidden, or a surface that scatters or absorbs them. It is 0 for rays that leave the
/// scene after going straight through all surfaces (Lobe::kNull). Its mean over a pixel's rays is
/// unbiased, without the Russian roulette of Mitsuba's alpha. A surface at which paths end because
/// of `max_depth` counts only if it emits. Not thread-safe: use one per thread.
class Coverage {
 public:
  /// Allocates memory for blocks of at most `rays` camera rays. `scene` and `sampler` must outlive
  /// this object.
  Coverage(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings,
           size_t rays);

  /// Sets the alpha of each ray that `camera` has traced. Uses the same random numbers as Paths use
  /// for BSDFs, so that alpha and colour of a path agree.
  void find(const PixelSamples& samples, const Camera& camera, float* alpha,
            RenderCounters& counters);

 private:
  size_t cover(const PixelSamples& samples, const Surfaces& surfaces, const uint32_t* owner,
               uint32_t depth, float* alpha);
  size_t pass(const SurfaceBlock& points, const Surfaces::Range& range, const uint32_t* owner,
              size_t rays, float* alpha);

  const SceneTable& scene_;
  const Sampler& sampler_;
  const uint32_t max_depth_;
  const bool is_opaque_;  ///< true if the scene has an environment that isn't hidden
  bool passes_ = false;   ///< true if some BSDF may pass rays straight through
  Numbers numbers_;
  Arena per_point_, per_ray_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  RayHit16* rays_;
  Surfaces met_;
  uint32_t* ray_owner_;  ///< samples of rays_
  uint32_t* owner_;      ///< samples of the points of met_
};

}  // namespace kinome::transport

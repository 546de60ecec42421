#pragma once

#include "../path_parameters.h"
#include "camera.h"
#include "kinome/stats.h"
#include "numbers.h"
#include "scene_table.h"
#include "shading.h"

namespace kinome::transport {

/// True if the camera sees an environment neither directly nor through what lets it straight
/// through.
inline bool hides_environment(const PathSettings& settings, const Scene& scene) {
  return settings.hide_emitters && scene.environment();
}

/// Alpha of camera rays, as Mitsuba's `path` defines it: 1 for rays that see an environment which
/// isn't hidden, or a surface that scatters or absorbs them; 0 for rays that leave the scene, all
/// of whose samples of BSDFs on the way went straight through (Lobe::kNull). Its mean over a pixel's
/// rays is unbiased: there is no Russian roulette, which Mitsuba's alpha suffers from. A surface at
/// which paths of `max_depth` end counts only if it emits. One per thread.
class Coverage {
 public:
  /// For blocks of at most `rays` camera rays; `scene` and `sampler` must outlive it.
  Coverage(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings,
           size_t rays);

  /// Sets the alpha of each ray that `camera` has traced. Random numbers are those of the samples'
  /// keys, in the dimensions in which Paths sample BSDFs, so that alpha and colour of a path agree.
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
  const bool is_opaque_;  ///< an environment is behind everything, and not hidden
  bool passes_ = false;   ///< some material may let rays straight through
  Numbers numbers_;
  Arena per_point_, per_ray_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  RayHit16* rays_;
  Surfaces met_;
  uint32_t* ray_owner_;  ///< of rays_
  uint32_t* owner_;      ///< of the points of met_
};

}  // namespace kinome::transport

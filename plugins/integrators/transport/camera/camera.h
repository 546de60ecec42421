#pragma once

#include "kinome/sensor.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Number of sampler dimensions that camera rays use: 0 and 1 for the position in the pixel, 2 and
/// 3 for the aperture, even if the sensor ignores it. Integrators use the dimensions after these.
inline constexpr uint32_t kCameraDimensions = 4;

/// Traced camera rays of a block, and the surfaces that they hit. Not thread-safe: use one per
/// thread.
class Camera {
 public:
  /// Allocates memory for blocks of at most `rays` samples. With `hide_emitters`, rays pass
  /// surfaces that emit, even those that also reflect light (as in Mitsuba).
  Camera(const SceneTable& scene, const Sensor& sensor, size_t rays, bool hide_emitters);

  void trace(const PixelSamples& samples, RenderCounters& counters);
  /// Computes rays() without tracing them.
  void make_rays(const PixelSamples& samples);
  /// Traces rays() only: surfaces() is not set, and emitters are not hidden.
  void trace_rays(const PixelSamples& samples, RenderCounters& counters);
  /// Traces rays through the given film positions. `aperture` is ignored by sensors that don't need
  /// it.
  void trace(const Columns2& film_position, const Columns2& aperture, size_t count,
             RenderCounters& counters);

  /// Camera rays, in the order of the samples.
  const RayHit16* rays() const { return rays_; }
  const Columns2& film_position() const { return position_; }
  /// Random numbers for the point of the lens where each ray begins; see Sensor::sample_ray.
  const Columns2& aperture() const { return aperture_; }
  const Surfaces& surfaces() const { return surfaces_; }
  /// Sets the radiance of each ray to the light that it sees directly: that of emitting surfaces
  /// and of the environment, by light group (SceneTable::group_offsets()). Sets 0 if emitters are
  /// hidden.
  void set_seen_light(const Columns3& radiance);
  /// Distance of the hit from the sensor's near plane, along the ray. Mitsuba's camera rays begin
  /// there. Valid only if ray i hit a surface and passed no emitter.
  float depth(size_t i) const {
    const Ray16& rays = rays_[i / kBlockLanes].ray;
    return rays.tmax[i % kBlockLanes] - rays.tmin[i % kBlockLanes];
  }
  bool hit(size_t i) const { return rays_[i / kBlockLanes].shape[i % kBlockLanes] != kNoHit; }
  /// Sets alpha to 1 for each ray that hit a surface, else to 0.
  void find_alpha(float* alpha) const;

 private:
  void place(const PixelSamples& samples);
  void make_rays(const Columns2& film_position, const Columns2& aperture, size_t count);
  void trace_rays(const Columns2& film_position, const Columns2& aperture, size_t count,
                  RenderCounters& counters);
  void pass_emitters(RenderCounters& counters);

  const SceneTable& scene_;
  const Sensor& sensor_;
  bool hide_emitters_;
  bool passes_;  ///< true if rays must pass emitters
  Arena arena_;
  Columns2 u_, aperture_, position_;
  RayHit16* rays_;
  size_t count_ = 0;
  RayHit16* beyond_;   ///< continuations of rays behind emitters
  uint32_t* passing_;  ///< indices of these rays
  float* far_;         ///< remaining length of each ray
  Columns3 toward_;   ///< directions of rays that leave the scene
  Surfaces surfaces_;
  Arena per_point_;
  Columns3 light_;
};

}  // namespace kinome::transport

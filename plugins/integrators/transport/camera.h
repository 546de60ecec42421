#pragma once

#include "surfaces.h"
#include "kinome/sensor.h"

namespace kinome::transport {

/// Dimensions of the sampler that camera rays take: 0, 1 for the place in the pixel, 2, 3 for the
/// aperture (whether or not the sensor uses it). What follows is the integrator's.
inline constexpr uint32_t kCameraDimensions = 4;

/// Camera rays of a block, traced, and the surfaces that they hit. One per thread.
class Camera {
 public:
  /// For blocks of at most `rays` samples. `hide_emitters`: rays go on through surfaces that emit,
  /// to what lies behind, whatever else such a surface does (as in Mitsuba).
  Camera(const SceneTable& scene, const Sensor& sensor, size_t rays, bool hide_emitters);

  void trace(const PixelSamples& samples, RenderCounters& counters);
  /// The same without what is needed of surfaces: rays() alone, and lights are not hidden.
  void trace_rays(const PixelSamples& samples, RenderCounters& counters);
  /// The rays through places on the film that somebody else has chosen; `aperture` means nothing to
  /// sensors that don't need it.
  void trace(const Columns2& film_position, const Columns2& aperture, size_t count,
             RenderCounters& counters);

  /// In the order of the samples.
  const RayHit16* rays() const { return rays_; }
  const Columns2& film_position() const { return position_; }
  /// Of the lens, where each ray comes from; see Sensor::sample_ray.
  const Columns2& aperture() const { return aperture_; }
  const Surfaces& surfaces() const { return surfaces_; }
  /// Sets the radiance of each ray to the light that it sees itself: of surfaces that emit and of
  /// the environment, or none where emitters are hidden.
  void set_seen_light(const Columns3& radiance);
  /// From the sensor's near plane, along the ray: what Mitsuba, whose camera rays begin there,
  /// takes for the distance of a hit. Only where ray i hit anything, and no light was passed.
  float depth(size_t i) const {
    const Ray16& rays = rays_[i / kBlockLanes].ray;
    return rays.tmax[i % kBlockLanes] - rays.tmin[i % kBlockLanes];
  }
  bool hit(size_t i) const { return rays_[i / kBlockLanes].shape[i % kBlockLanes] != kNoHit; }
  /// 1 for each ray that hit anything, else 0.
  void find_alpha(float* alpha) const;

 private:
  void place(const PixelSamples& samples);
  void trace_rays(const Columns2& film_position, const Columns2& aperture, size_t count,
                  RenderCounters& counters);
  void pass_emitters(RenderCounters& counters);

  const SceneTable& scene_;
  const Sensor& sensor_;
  bool hide_emitters_;
  bool passes_;  ///< there are emitters to pass
  Arena arena_;
  Columns2 u_, aperture_, position_;
  RayHit16* rays_;
  size_t count_ = 0;
  RayHit16* beyond_;  ///< of rays that go on
  uint32_t* passing_;
  float* far_;        ///< how far each ray sees
  Columns3 toward_;   ///< directions of rays that leave the scene
  Surfaces surfaces_;
  Arena per_point_;
  Columns3 light_;
};

}  // namespace kinome::transport

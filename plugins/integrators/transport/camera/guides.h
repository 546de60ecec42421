#pragma once

#include "transport/camera/camera.h"

namespace kinome::transport {

/// Auxiliary images for denoisers: albedo and normal of the first rough surface that each camera
/// ray reaches, straight or through mirrors and smooth glass. Not thread-safe: use one per thread.
///
/// At a mirror, the ray continues; at smooth glass, it is reflected or refracted at random. The
/// albedo is the surface's reflectance (diffuse and glossy lobes, without perfect mirrors), times
/// the weights of the surfaces before it, between 0 and 1. Emitters and the environment have the
/// albedo min(radiance, 1), so that a denoiser keeps their texture. The normal is the one that the
/// BSDF uses (normal maps included), in world space, turned to the ray. Rays that leave the scene
/// have the normal of the last surface, or 0 without one.
class Guides {
 public:
  /// Allocates memory for blocks of at most `rays` samples.
  Guides(const SceneTable& scene, const Sensor& sensor, size_t rays);

  /// Follows the camera's traced rays of these samples.
  void find(const Camera& camera, const PixelSamples& samples, RenderCounters& counters);
  /// Albedo and normal of each sample, in the order of the samples.
  const Columns3& albedo() const { return albedo_; }
  const Columns3& normal() const { return normal_; }

 private:
  void record(uint32_t sample, const kinome::Rgb& color);
  void record_sky(const RayHit16* rays, const uint32_t* sample_of);
  /// Sets `next` to the continuation of the ray that hit `si`, and returns true; returns false
  /// after recording the surface, where the ray ends.
  bool follow(const SurfaceInteraction& si, uint32_t sample, bool may_continue, Ray& next);

  const SceneTable& scene_;
  const Sampler& sampler_;
  Arena arena_;
  Columns3 albedo_, normal_;
  Columns3 weight_;  ///< product of the weights of the surfaces that a ray has passed
  float* u_;
  RayHit16* rays_[2];       ///< rays of this bounce and of the next one
  uint32_t* sample_of_[2];  ///< sample of each ray
  Surfaces surfaces_;
};

}  // namespace kinome::transport

#pragma once

#include "clustered/media/fog_sources.h"
#include "transport/arena.h"
#include "transport/media/volume_paths.h"

namespace kinome {

/// Emitter samples for single points, on surfaces and in media. Sources are chosen by the
/// irradiance that they would cause without occlusion and attenuation; in media, by that on a plane
/// that faces them. One per thread.
class PointLightChoice final : public transport::LightChoice {
 public:
  /// `directions` may change between calls of sample().
  PointLightChoice(const FogSources& sources, const SkyDirections& directions);

  void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
              const SurfaceBlock& points, const uint32_t* owner, size_t count,
              transport::Numbers& numbers, const DirectBlock& out, float* emitter_pdf) override;

 private:
  struct Chosen {
    uint32_t source;
    float probability;
  };
  Chosen choose(const Vec3& p, const Vec3& n, float u) const;

  const FogSources& sources_;
  const SkyDirections& directions_;
  transport::Arena arena_;
  /// Columns of near sources, padded, then of distant ones.
  Columns3 place_;  ///< position, or direction
  float *intensity_, *radius2_;
  float* weight_;  ///< of the sources for the current point
};

}  // namespace kinome

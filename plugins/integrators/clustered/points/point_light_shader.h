#pragma once

#include "clustered/points/light_pairs.h"
#include "clustered/points/mirrors.h"
#include "clustered/points/point_lights.h"
#include "clustered/points/single_lights.h"

namespace kinome {

/// Shades the surfaces that the camera rays of a block hit. One per thread.
class PointLightShader {
 public:
  /// For blocks of at most `rays` samples.
  PointLightShader(const transport::SceneTable& scene, const ScenePointLights& lights,
                   const PointLightOptions& options, const Sampler& sampler, size_t rays);

  /// Adds the light that the surfaces reflect.
  void add(const PixelSamples& samples, const transport::Surfaces& seen, const Columns3& radiance,
           RenderCounters& counters);

 private:
  void light_points(const PixelSamples& samples, const transport::Vertices& vertices,
                    uint32_t depth, const Columns3& radiance, RenderCounters& counters);
  uint32_t first_dimension(uint32_t depth) const;

  const ScenePointLights& lights_;
  const PointLightOptions& options_;
  bool has_mirrors_;
  LightPairs pairs_;
  SingleLights single_lights_;
  Mirrors mirrors_;
  transport::Arena arena_;
  float* straight_ = nullptr;  ///< see transport::Vertices
};

}  // namespace kinome

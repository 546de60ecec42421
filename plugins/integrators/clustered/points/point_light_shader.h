#pragma once

#include "clustered/points/light_pairs.h"
#include "clustered/points/point_lights.h"
#include "clustered/points/single_lights.h"
#include "transport/direct_light.h"

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
  transport::Vertices reflect(const PixelSamples& samples, const transport::Vertices& vertices,
                              uint32_t dimension, const Columns3& radiance,
                              RenderCounters& counters);

  const ScenePointLights& lights_;
  const PointLightOptions& options_;
  bool has_mirrors_;
  LightPairs pairs_;
  SingleLights single_lights_;
  transport::DirectLight mirrors_;
  transport::Arena arena_;
  transport::Arena per_point_;
  /// State at the points that mirrors reflect: of the last call of reflect(), and of the one before.
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  int current_ = 0;
  float* straight_ = nullptr;  ///< see transport::Vertices
};

}  // namespace kinome

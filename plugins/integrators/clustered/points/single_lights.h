#pragma once

#include "transport/emitter_samples.h"
#include "transport/occlusion.h"
#include "transport/shading.h"
#include "transport/vertices.h"

namespace kinome {

/// Light of emitters without light points: one sample of each, for each point. One per thread.
class SingleLights {
 public:
  /// For points of blocks of at most `rays` rays.
  SingleLights(const transport::SceneTable& scene, const Sampler& sampler, size_t rays);

  /// Adds the light of `emitters`. Uses two dimensions of the sampler for each, from `dimension`
  /// on.
  void add(const PixelSamples& samples, const transport::Vertices& vertices,
           std::span<const Emitter* const> emitters, uint32_t dimension, const Columns3& radiance,
           RenderCounters& counters);

 private:
  void sample(const PixelSamples& samples, const transport::Vertices& vertices,
              const Emitter& emitter, uint32_t dimension, RenderCounters& counters);

  const Scene& scene_;
  const Sampler& sampler_;
  transport::Numbers numbers_;
  transport::Arena arena_;
  uint32_t* all_;
  Columns2 u_;
  DirectBlock light_;
  Columns3 wo_;
  BsdfAnswer answer_;
  Columns3 reflected_;
  Ray16* rays_;
  transport::Occlusion occlusion_;
};

}  // namespace kinome

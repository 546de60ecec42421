#pragma once

#include "transport/numbers.h"
#include "transport/occlusion.h"
#include "transport/shading.h"
#include "transport/vertices.h"

namespace kinome {

/// Reflections in perfect mirrors, to which light points can't contribute: traces rays from points
/// that have delta lobes to the next surfaces. One per thread.
class Mirrors {
 public:
  /// For points of blocks of at most `rays` rays.
  Mirrors(const transport::SceneTable& scene, const Sampler& sampler, size_t rays);

  /// Adds the emitted light that the mirrors among `vertices` reflect. Returns the surfaces that
  /// they reflect, valid through the next call. Uses three dimensions of the sampler from
  /// `dimension` on.
  transport::Vertices reflect(const PixelSamples& samples, const transport::Vertices& vertices,
                              uint32_t dimension, const Columns3& radiance,
                              RenderCounters& counters);

 private:
  void make_rays(const PixelSamples& samples, const transport::Vertices& vertices,
                 uint32_t dimension);
  void add_light(const transport::Vertices& met, const Columns3& radiance);
  void add_environment(const transport::Vertices& vertices, const Columns3& radiance);

  const transport::SceneTable& scene_;
  const Sampler& sampler_;
  transport::Numbers numbers_;
  transport::Arena arena_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  Columns3 d_;        ///< directions, world space
  Columns3 carried_;  ///< throughput along d_
  Columns3 light_;
  Ray16* rays_;
  transport::DirectionSort sort_;
  RayHit16* traced_;
  /// Hits of the last call and of the one before, whose points may be the vertices of this one.
  transport::Surfaces met_[2];
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  int current_ = 0;
};

}  // namespace kinome

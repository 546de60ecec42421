#pragma once

#include "transport/numbers.h"
#include "transport/occlusion.h"
#include "transport/shading.h"
#include "transport/vertices.h"

namespace kinome {

/// What perfect mirrors show, which no light point can light: rays from points that have delta
/// lobes to the next surfaces. One per thread.
class Mirrors {
 public:
  /// For points of blocks of at most `rays` rays.
  Mirrors(const transport::SceneTable& scene, const Sampler& sampler, size_t rays);

  /// Adds the light that the mirrors among `vertices` show, and returns the surfaces that they
  /// show, valid through the next call. Takes three numbers of the sampler from `dimension` on.
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
  Columns3 d_;        ///< in the world
  Columns3 carried_;  ///< throughput along it
  Columns3 light_;
  Ray16* rays_;
  transport::DirectionSort sort_;
  RayHit16* traced_;
  /// Of the last call and of the one before, whose points may be the vertices of this one.
  transport::Surfaces met_[2];
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  int current_ = 0;
};

}  // namespace kinome

#pragma once

#include <array>

#include "transport/media/tracking/segments.h"
#include "transport/path_parameters.h"

namespace kinome::transport {

/// Random walks inside of enclosed homogeneous media (MediaTable::is_walked): from a collision,
/// through any number of others, to a surface. No emitter is sampled on the way, so that a step
/// needs no more than a direction, a distance and a ray. Not thread-safe: use one per thread.
///
/// Russian roulette keeps walks in proportion to their throughput (see weight_of_length()). It has
/// no upper limit, unlike the 95 % of paths on surfaces, because light takes a hundred collisions
/// to leave wax.
class Walks {
 public:
  /// Allocates memory for at most `rays` rays.
  Walks(const SceneTable& scene, const MediaTable& media, const PathLength& length, size_t rays);

  /// Columns of the paths that walks read or change in addition to PathState.
  struct PathColumns {
    const float* scale;  ///< see VolumePaths::State
    Columns3 from;
    float* pdf;
    float* alpha;  ///< alpha of the samples of the block; may be nullptr
  };
  /// Continues the paths whose rays end at collisions in such media. Afterwards, such a ray ends at
  /// a surface, leaves the scene, or ends at a collision where a delta emitter must be sampled
  /// (MediaTable::delta_share()). Paths that have ended have throughput 0.
  void walk(RayHit16* rays, size_t count, const PathState& state, const PathColumns& paths,
            const RandomSeeds& seeds, RenderCounters& counters);

 private:
  void begin(uint32_t medium, RayHit16* rays, size_t count, const PathState& state,
             const PathColumns& paths, const RandomSeeds& seeds);
  void collide(uint32_t medium, uint32_t step, RayHit16* rays, const PathState& state,
               const PathColumns& paths);
  void scatter(uint32_t medium, uint32_t step);
  void trace(uint32_t medium, RayHit16* rays, const PathState& state, const PathColumns& paths,
             RenderCounters& counters);
  void leave(size_t i, const PathState& state, const PathColumns& paths) const;
  void compact();

  const SceneTable& scene_;
  const MediaTable& media_;
  const PathLength length_;
  Arena arena_;
  size_t count_ = 0;  ///< number of walks that continue
  uint32_t* path_;    ///< index of the ray in walk()
  Columns3 p_, d_, throughput_;
  float *scatterings_, *scale_;
  uint32_t *low_, *high_;  ///< seed of the random numbers
  std::array<float*, 11> float_columns_;
  std::array<uint32_t*, 3> index_columns_;
  Columns3 s_, t_, n_, wo_;
  float *u1_, *pdf_, *u_distance_, *goes_on_;
  Columns2 u2_;
  uint32_t* channel_;
  RayHit16* rays_;
};

}  // namespace kinome::transport

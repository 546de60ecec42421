#pragma once

#include "../path_parameters.h"
#include "adjoint_samples.h"
#include "emission.h"
#include "shading.h"
#include "splats.h"
#include "surfaces.h"

namespace kinome::transport {

/// Paths from the emitters, every surface point of which is connected to the camera (Veach 1997,
/// 10.1; see adjoint.h). The paths of a block go on together, one edge at a time, and those
/// that go on move together after each. One per thread.
class LightPaths {
 public:
  /// For blocks of at most `samples` samples. The scene must have emitters. `hide_emitters`: light
  /// that comes straight from a surface is left out.
  LightPaths(const SceneTable& scene, const Sensor& sensor, const PathLength& length,
             bool hide_emitters, size_t samples);

  /// Traces one path for each sample. A path has nothing to do with the pixel that numbers it.
  void trace(const PixelSamples& samples, Tile& tile);

 private:
  /// Dimensions of the sampler: beside the emission the lens; then for each surface point the lens,
  /// the lobe, whereto, the roulette.
  static constexpr uint32_t kEmissionDimensions = Emission::kDimensions + 2;
  static constexpr uint32_t kPointDimensions = 6;

  /// What belongs to paths.
  struct State {
    uint32_t* owner;         ///< the sample
    Columns3 power;          ///< that arrives at the next point [W]
    float* inverse_emitted;  ///< 1 / the largest channel of what it began with
  };
  static State make_state(Arena& arena);

  void connect_emitters(const PixelSamples& samples, RenderCounters& counters);
  void connect_emitter(const Emission::Range& range, RenderCounters& counters);
  void emit(const PixelSamples& samples);
  void find_points(Tile& tile);
  void connect_points(const PixelSamples& samples, uint32_t dimension, RenderCounters& counters);
  void scatter(const PixelSamples& samples, uint32_t depth, uint32_t dimension);
  void put_rays(const BsdfAnswer& sampled, bool plays_roulette);

  const SceneTable& scene_;
  const Sensor& sensor_;
  PathLength length_;
  bool hide_emitters_;
  Numbers numbers_;
  Emission emission_;
  Surfaces met_;
  Arena arena_;
  Splats splats_;
  SurfaceBlock emitting_;  ///< points of emitters
  Columns3 light_;         ///< that they emit toward the camera
  Columns3 seen_from_;     ///< where points are seen from, in their frames
  float* u1_;
  Columns2 u2_;
  AdjointSamples next_;
  BsdfAnswer seen_;
  /// Of rays that may go on, and of the points that they have come to.
  State from_, at_;
  Ray16* rays_;
  DirectionSort sort_;
  RayHit16* traced_;
};

}  // namespace kinome::transport

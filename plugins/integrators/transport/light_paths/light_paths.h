#pragma once

#include "transport/light_paths/adjoint_samples.h"
#include "transport/light_paths/emission.h"
#include "transport/light_paths/splats.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/shading.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Paths from the emitters. Each of their surface points is connected to the camera (Veach 1997,
/// 10.1; see adjoint.h). The paths of a block advance together, one edge at a time; after each
/// edge, the remaining paths are compacted. Not thread-safe: use one per thread.
class LightPaths {
 public:
  /// Allocates memory for blocks of at most `samples` samples. The scene must have emitters. With
  /// `hide_emitters`, omits the light that emitting surfaces send directly to the camera.
  LightPaths(const SceneTable& scene, const Sensor& sensor, const PathLength& length,
             bool hide_emitters, size_t samples);

  /// Traces one path for each sample. The sample's pixel only selects the path's random numbers.
  void trace(const PixelSamples& samples, Tile& tile);

 private:
  /// Numbers of sampler dimensions: emission and lens; then for each surface point the lens, the
  /// lobe, the direction and the roulette.
  static constexpr uint32_t kEmissionDimensions = Emission::kDimensions + 2;
  static constexpr uint32_t kPointDimensions = 6;

  /// State of paths.
  struct State {
    uint32_t* owner;         ///< sample of each path
    Columns3 power;          ///< power that arrives at the next point [W]
    float* inverse_emitted;  ///< 1 / the largest channel of the emitted power
  };
  static State make_state(Arena& arena);

  void connect_emitters(const PixelSamples& samples, RenderCounters& counters);
  void connect_emitter(const Emission::Range& range, RenderCounters& counters);
  void emit(const PixelSamples& samples);
  void find_points(Tile& tile);
  void connect_points(const PixelSamples& samples, uint32_t dimension, RenderCounters& counters);
  void scatter(const PixelSamples& samples, uint32_t depth, uint32_t dimension);
  void write_rays(const BsdfAnswer& sampled, bool plays_roulette);

  const SceneTable& scene_;
  const Sensor& sensor_;
  PathLength length_;
  bool hide_emitters_;
  Numbers numbers_;
  Emission emission_;
  Surfaces met_;
  Arena arena_;
  Splats splats_;
  SurfaceBlock emitting_;  ///< points on emitters
  Columns3 light_;         ///< radiance that they emit toward the camera
  Columns3 seen_from_;     ///< directions from points to the camera, in their frames
  float* u1_;
  Columns2 u2_;
  AdjointSamples next_;
  BsdfAnswer seen_;
  /// State of the rays before tracing, and of the points that they hit.
  State from_, at_;
  Ray16* rays_;
  DirectionSort sort_;
  RayHit16* traced_;
};

}  // namespace kinome::transport

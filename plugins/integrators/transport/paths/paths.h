#pragma once

#include "transport/camera/camera.h"
#include "transport/direct/direct_light.h"
#include "transport/path_parameters.h"

namespace kinome::transport {

/// Destinations of the light of a block's samples, by the length of its paths.
struct RadianceByLength {
  Columns3 radiance;  ///< light of paths of up to `longest` edges
  Columns3 beyond;    ///< all other light; may be the same columns as `radiance`
  uint32_t longest = kNoMaxDepth;
};

/// Paths from the camera. Every surface point gets direct light from emitter samples and BSDF
/// samples, combined by the power heuristic (Veach 1997, 9.2.4 and 10.3.3). The BSDF sample is also
/// the next edge. Paths find all light except that of lamps (emitters without area) in mirrors. The
/// paths of a block advance together, one edge at a time; after each edge, the remaining paths are
/// compacted. Not thread-safe: use one per thread.
///
/// Emitter samples, except those of lamps, pass straight through panes and masks (Lobe::kNull).
/// Each such surface counts as an edge. The sample is multiplied by the product of the
/// transmittances. BSDF samples find the same light with their density times the probability of
/// passing.
class Paths {
 public:
  /// Allocates memory for blocks of at most `rays` paths. `settings.hide_emitters` affects only
  /// paths that begin at the camera.
  Paths(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings, size_t rays);

  /// Returns the first sampler dimension for the BSDF of a point that is `depth` edges from the
  /// camera.
  static constexpr uint32_t bsdf_dimension(uint32_t depth) {
    return kCameraDimensions + kPointDimensions * (depth - 1) + DirectLight::kDimensions;
  }

  /// Adds the light that surfaces hit by camera rays reflect: light of paths of at least two edges.
  void add(const PixelSamples& samples, const Surfaces& seen, const RadianceByLength& light,
           RenderCounters& counters);
  /// The same for paths that begin at `vertices`, which are `depth` edges from the camera.
  void go_on(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
             const RadianceByLength& light, RenderCounters& counters);

 private:
  /// Number of sampler dimensions for a surface point: an emitter sample, a BSDF sample, the
  /// roulette.
  static constexpr uint32_t kPointDimensions = 2 * DirectLight::kDimensions + 1;

  void extend(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
              const RadianceByLength& light, RenderCounters& counters);
  Vertices next(const Vertices& vertices, int buffer);
  void add_emitter_samples(const Vertices& vertices, uint32_t depth, const RadianceByLength& light,
                           RenderCounters& counters);
  /// Returns the origins of the first vertices, where no emitter samples were taken before.
  Origins first_origins(const Vertices& vertices, int buffer) const;

  const SceneTable& scene_;
  PathLength length_;
  bool hides_environment_;
  DirectLight light_;
  Arena arena_;
  /// State at the points that paths have reached, and at the next ones.
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  float* straight_;     ///< see Vertices
  Origins origins_[2];  ///< columns are nullptr if emitter samples stop at all surfaces
};

}  // namespace kinome::transport

#pragma once

#include "../path_parameters.h"
#include "camera.h"
#include "direct_light.h"

namespace kinome::transport {

/// Where the light of a block's samples goes, by how long the paths are that it comes by.
struct RadianceByLength {
  Columns3 radiance;  ///< of paths of up to `longest` edges
  Columns3 beyond;    ///< of all others; may be the same
  uint32_t longest = kNoMaxDepth;
};

/// Paths from the camera: at every surface point, light straight from the emitters, by emitter
/// sampling and BSDF sampling combined by the power heuristic (Veach 1997, 9.2.4 and 10.3.3); the
/// BSDF sample is also the next edge. All emitters are found, save that light of a point or a
/// direction is not seen in mirrors. The paths of a block go on together, one edge at a time, and
/// those that go on move together after each. One per thread.
///
/// Emitter samples of all other emitters pass surfaces straight (Lobe::kNull: panes, masks). Each
/// surface counts as an edge. The sample carries the product of the transmittances; BSDF samples,
/// which find the same light, have their density times the probability of passing.
class Paths {
 public:
  /// For blocks of at most `rays` paths. `settings.hide_emitters` is of paths that begin at the
  /// camera.
  Paths(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings, size_t rays);

  /// The first of the sampler's dimensions that the BSDF of a point takes, `depth` edges from the
  /// camera.
  static constexpr uint32_t bsdf_dimension(uint32_t depth) {
    return kCameraDimensions + kPointDimensions * (depth - 1) + DirectLight::kDimensions;
  }

  /// Adds what the surfaces that the camera rays hit reflect, which is light by paths of two edges
  /// and more.
  void add(const PixelSamples& samples, const Surfaces& seen, const RadianceByLength& light,
           RenderCounters& counters);
  /// The same of paths that begin elsewhere, at `vertices` that lie `depth` edges from the camera.
  void go_on(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
             const RadianceByLength& light, RenderCounters& counters);

 private:
  /// Dimensions of the sampler for a surface point: an emitter sample, a BSDF sample, the roulette.
  static constexpr uint32_t kPointDimensions = 2 * DirectLight::kDimensions + 1;

  void extend(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
              const RadianceByLength& light, RenderCounters& counters);
  Vertices next(const Vertices& vertices, int buffer);
  void add_emitter_samples(const Vertices& vertices, uint32_t depth, const RadianceByLength& light,
                           RenderCounters& counters);
  /// Origins of vertices at which no path of these has turned before.
  Origins first_origins(const Vertices& vertices, int buffer) const;

  const SceneTable& scene_;
  PathLength length_;
  bool hides_environment_;
  DirectLight light_;
  Arena arena_;
  /// Of the points that paths have come to, and of the next ones.
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  float* straight_;     ///< see Vertices
  Origins origins_[2];  ///< nullptr: emitter samples stop at all surfaces
};

}  // namespace kinome::transport

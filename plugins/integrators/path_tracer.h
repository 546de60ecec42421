#pragma once

#include <span>
#include <vector>

#include "direct_light.h"
#include "path_parameters.h"

namespace kinome {

struct PathSettings {
  PathLength length;
  bool hide_emitters = false;
};

/// Radiance of each primary ray, divided by how long the paths are that light comes by.
struct RadianceByLength {
  std::span<Rgb> radiance;  ///< of paths of up to `longest` edges
  std::span<Rgb> beyond;    ///< of all others; may be the same
  uint32_t longest = kNoMaxDepth;
};

/// Paths from the camera: at every surface point, light straight from the emitters, by emitter
/// sampling and BSDF sampling combined by the power heuristic (Veach 1997, 9.2.4 and 10.3.3); the
/// BSDF sample is also the next edge. All emitters are found, save that light of a point or a
/// direction is not seen in mirrors. Many paths go on together, one edge at a time, so that rays
/// are traced in batches. What one thread works with, kept from batch to batch: not thread-safe.
class PathTracer {
 public:
  /// Adds what the surfaces that the primary rays hit reflect, which is light by paths of two edges
  /// and more.
  void trace(const PathSettings& settings, const Scene& scene, const Sampler& sampler,
             const PrimaryBatch& primary, const RadianceByLength& light, RenderCounters& counters);

 private:
  void play_roulette(const Sampler& sampler, uint32_t dimension);
  void extend_paths(const PathSettings& settings, const DirectLight::Context& context,
                    uint32_t depth, std::span<Rgb> radiance);

  DirectLight light_;
  std::vector<ShadingPoint> points_;  ///< where the paths that go on have come to
  std::vector<ShadingPoint> next_points_;
  /// The surfaces of points_ and of next_points_, from the second point of a path on.
  std::vector<SurfaceInteraction> surfaces_;
  std::vector<SurfaceInteraction> next_surfaces_;
};

/// Integrator::render of `path`.
void render_paths(const PathSettings& settings, const Scene& scene, const Sensor& sensor,
                  RenderContext& context);

}  // namespace kinome

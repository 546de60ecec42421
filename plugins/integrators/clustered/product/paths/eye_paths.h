#pragma once

#include <span>
#include <vector>

#include "clustered/product/lights/local_light.h"
#include "kinome/scene.h"
#include "transport/paths/paths.h"

namespace kinome {

/// Continues rays as paths: adds the light that the surfaces they hit reflect, from emitter and
/// BSDF samples (transport::Paths). Paths wait until trace(). One per thread; not thread-safe.
class EyePaths {
 public:
  /// `edges_before` is the number of edges from the camera to the origins of the rays. Paths that
  /// start at the camera obey `settings.hide_emitters`. Points of `light` may find the same light;
  /// Begin::rates gives their balance weight. `light` is nullptr if there are none, and must
  /// outlive this object. Rays pass surfaces straight if LocalLight::passing() isn't nullptr.
  /// `groups`: groups by which light is divided, or nullptr.
  EyePaths(const Scene& scene, const PathSettings& settings, uint32_t edges_before,
           const LocalLight* light, const LightGroups* groups);
  ~EyePaths();

  struct Begin {
    Ray ray;
    Rgb throughput{0.f};
    float density = kInfinity;  ///< of the ray's direction; infinity for a delta lobe
    /// Weights of the light of emitters seen through a chain of delta lobes. `shown_share`: the
    /// chain includes this ray or starts at its end. `shown_share_later`: it starts later.
    float shown_share = 1, shown_share_later = 1;
    /// LocalChoice::rates() of the tile.
    std::span<const float> rates;
    uint64_t seed = 0;
    Rgb* sum = nullptr;   ///< of the first light group; those of the others follow
    uint32_t passes = 0;  ///< number of surfaces that the path has passed straight
    float before = 0;     ///< distance from the start to the last surface that this ray has passed
  };
  /// Adds throughput x the radiance that arrives along the ray to `sum`, without emitters that the
  /// ray hits itself. `sum` and `rates` must remain valid until trace().
  void push(const Begin& path) {
    if (waiting_.size() <= path.passes) waiting_.resize(path.passes + 1);
    waiting_[path.passes].push_back(path);
  }
  bool empty() const { return waiting_.empty(); }
  void trace(RenderCounters& counters);

 private:
  struct Block;

  /// Balance weights of paths for the light that z reflects. Light points have the rest.
  struct Shares {
    float all = 1;
    float shown = 1;  ///< additional factor for light that delta lobes show there
  };
  Shares shares_of_path(const Begin& path, const SurfaceInteraction& z, float distance) const;
  void trace(std::span<const Begin> paths, RenderCounters& counters);
  void pass(const Begin& path, const SurfaceInteraction& z, float distance);

  const Scene& scene_;
  const PathSettings settings_;
  const uint32_t edges_before_;
  const LocalLight* const light_;
  const LightGroups* const groups_;
  std::vector<std::vector<Begin>> waiting_;  ///< indexed by Begin::passes
  std::unique_ptr<Block> block_;             ///< allocated when the first path is traced
};

}  // namespace kinome

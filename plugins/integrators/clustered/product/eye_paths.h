#pragma once

#include <span>
#include <vector>

#include "clustered/product/local_light.h"
#include "kinome/scene.h"
#include "transport/paths.h"

namespace kinome {

/// Paths that go on along rays toward surfaces: what these reflect of light from emitter and BSDF
/// samples (transport::Paths). They wait until trace(). One per thread; not thread-safe.
class EyePaths {
 public:
  /// `edges_before` is the number of edges from the camera to where the rays begin; paths that begin
  /// at the camera obey `settings.hide_emitters`. Points of `light` may see the surfaces, too, and
  /// have a share (Begin::rates); nullptr if there are none. It must outlive this object. If light
  /// passes surfaces straight (LocalLight::passing), the rays do.
  EyePaths(const Scene& scene, const PathSettings& settings, uint32_t edges_before,
           const LocalLight* light);
  ~EyePaths();

  struct Begin {
    Ray ray;
    Rgb throughput{0.f};
    float density = kInfinity;  ///< of the ray's direction; infinite: of a delta lobe
    /// In light of emitters that a chain of delta lobes shows which goes on with this ray, or
    /// begins where it ends; and, if that is elsewhere, in what others show.
    float shown_share = 1, shown_share_later = 1;
    /// Of the tile that it is for: expected number of looks at a light point of each cell.
    std::span<const float> rates;
    uint64_t seed = 0;  ///< of the random numbers
    Rgb* sum = nullptr;
    uint32_t passes = 0;  ///< surfaces that the path has passed straight
    float before = 0;     ///< distance from the start to the last of them, if this ray has passed any
  };
  /// Adds throughput x the radiance that comes along the ray, that of emitters which the ray meets
  /// itself left out, to `sum`. That and `rates` must stay where they are until trace().
  void push(const Begin& path) {
    if (waiting_.size() <= path.passes) waiting_.resize(path.passes + 1);
    waiting_[path.passes].push_back(path);
  }
  bool empty() const { return waiting_.empty(); }
  void trace(RenderCounters& counters);

 private:
  struct Block;

  /// Of what z sends on; light points have the rest.
  struct Shares {
    float all = 1;
    float shown = 1;  ///< of light that delta lobes show there: times `all`
  };
  Shares shares_of_path(const Begin& path, const SurfaceInteraction& z, float distance) const;
  void trace(std::span<const Begin> paths, RenderCounters& counters);
  void pass(const Begin& path, const SurfaceInteraction& z, float distance);

  const Scene& scene_;
  const PathSettings settings_;
  const uint32_t edges_before_;
  const LocalLight* const light_;
  std::vector<std::vector<Begin>> waiting_;  ///< by Begin::passes
  std::unique_ptr<Block> block_;  ///< nullptr until paths are traced, which some threads never do
};

}  // namespace kinome

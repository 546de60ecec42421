#pragma once

#include <vector>

#include "clustered/product/cell_light.h"
#include "kinome/render_context.h"

namespace kinome {

/// Light of emitters that chains of delta lobes (mirrors, smooth glass) show to what the camera
/// sees, found from there: rays that go on by delta lobes alone and count what they meet of
/// emitters. Where paths from the emitters find the same light, too, they have but their share of
/// it (Caustics). Rays wait until trace(). One per thread; not thread-safe.
class EyeChains {
 public:
  /// `light`, which has local light, must outlive this.
  explicit EyeChains(const CellLight& light) : light_(light) {}

  struct Begin {
    Rgb weight{0.f};  ///< of the radiance that y sends on
    /// Caustics::eye_density of the chain; infinite: nothing else finds its light.
    float density = kInfinity;
    uint64_t seed = 0;  ///< of the random numbers
    Rgb* sum = nullptr;
    uint32_t edges = 2;  ///< from the camera to where the chain begins
  };
  /// From y, which has delta lobes. If light passes surfaces straight, others follow what goes
  /// straight on from y.
  void push(const SurfaceInteraction& y, const Begin& begin);
  void trace(const Scene& scene, RenderCounters& counters);

 private:
  void go_on(const SurfaceInteraction& y, const Begin& begin, bool drops_straight);
  void add(const Begin& chain, const Emitter& emitter, const SurfaceInteraction* x, const Vec3& d,
           const Rgb& radiance) const;

  const CellLight& light_;
  std::vector<RayHit> rays_;
  std::vector<Begin> chains_;  ///< of the rays; `edges` with the ray
};

}  // namespace kinome

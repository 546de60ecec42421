#pragma once

#include <vector>

#include "clustered/product/choice/cell_light.h"
#include "kinome/render_context.h"

namespace kinome {

/// Number of eye rays of one call to Embree.
inline constexpr size_t kEyeRaysPerCall = 1024;

/// Emitters seen through chains of delta lobes (mirrors, smooth glass) from the surface points that
/// the camera sees. Rays follow delta lobes alone, and add the light of emitters that they hit. If
/// paths from the emitters (Caustics) find the same light, balance weights divide it. Rays wait
/// until trace(). One per thread; not thread-safe.
class EyeChains {
 public:
  /// `light` must have local light, and outlive this object.
  explicit EyeChains(const CellLight& light) : light_(light) {}

  struct Begin {
    Rgb weight{0.f};  ///< factor of the radiance that y reflects or transmits
    /// Caustics::eye_density of the chain; infinity if nothing else finds its light.
    float density = kInfinity;
    uint64_t seed = 0;
    Rgb* sum = nullptr;  ///< of the first light group; those of the others follow
    uint32_t edges = 2;  ///< from the camera to the start of the chain
  };
  /// Starts a chain at y, which has delta lobes. Straight transmission at y is left out if the
  /// scene has surfaces that light passes straight, because other rays follow it.
  void push(const SurfaceInteraction& y, const Begin& begin) {
    go_on(y, begin, light_.passing() != nullptr);
  }
  void trace(const Scene& scene, RenderCounters& counters);

 private:
  void go_on(const SurfaceInteraction& y, const Begin& begin, bool drops_straight);
  void add(const Begin& chain, const Emitter& emitter, const SurfaceInteraction* x, const Vec3& d,
           const Rgb& radiance) const;

  const CellLight& light_;
  std::vector<RayHit> rays_;
  std::vector<Begin> chains_;  ///< of each ray; `edges` includes the ray
};

}  // namespace kinome

#pragma once

#include <optional>
#include <span>
#include <vector>

#include "clustered/product/choice/candidates.h"
#include "clustered/product/choice/cell_light.h"
#include "clustered/product/paths/eye_chains.h"
#include "clustered/product/paths/eye_paths.h"
#include "clustered/product/choice/local_choice.h"
#include "clustered/product/choice/point_choice.h"
#include "clustered/product/rays/shadow_rays.h"

namespace kinome {

/// Eye rays: rays that primaries sample by their BSDFs. They find local light that is too near for
/// light points, and light that arrives by mirrors or by lobes too narrow for light points. Balance
/// weights divide light that other techniques find as well. Rays wait until trace(). One per
/// thread; not thread-safe. `light` must have local light and outlive it.
class EyeRays {
 public:
  explicit EyeRays(const CellLight& light) : light_(light), chains_(light), points_(light) {}

  /// Begins the tile from which the next rays are sent. `choice` is that of the tile.
  void begin_tile(const Scene& scene, const LocalChoice& choice, uint64_t seed,
                  RenderCounters& counters);

  /// False if the group sends no such rays.
  bool applies(const GroupView& group) const;
  /// Sends a ray from each member of the group with probability `expected`. Random numbers depend
  /// on `seed` and the primary.
  void send(const GroupView& group, float expected, uint64_t seed, const UnitSums& sums);
  /// Sends a ray by the delta lobes of a primary. It finds all of their light.
  void send_mirrored(const SurfaceInteraction& si, uint32_t primary, uint64_t seed, Rgb& sum);

  bool empty() const { return rays_.empty(); }
  /// Traces the waiting rays and the paths that continue at their hits, and adds the light that
  /// they find. Shadow rays for light that arrives at the hits are added to `shadow_rays`, not
  /// traced.
  void trace(ShadowRays& shadow_rays);

 private:
  struct EyeRay {
    Rgb weight;     ///< factor of the radiance that it finds
    float density;  ///< expected number of such rays, per solid angle; 0 for a delta lobe
    uint32_t tile;  ///< index in tiles_
    uint64_t seed;
    Rgb* sum;       ///< of the first light group; those of the others follow
    float chain_density = kInfinity;  ///< EyeChains::Begin::density
    uint32_t passes = 0;              ///< number of surfaces that it has passed straight
    float before = 0;                 ///< distance to the last of these
  };
  /// A tile with waiting rays.
  struct Tile {
    size_t rates;  ///< index of the first of its rates in rates_
    PointChoice::Block points;
  };
  /// An emitter that a ray from a surface hits.
  struct Met {
    std::optional<SurfaceInteraction> x;  ///< nullopt for the sky
    float distance = 0;
    Rgb radiance{0.f};
  };
  void draw(const GroupView& group, uint64_t seed);
  void push(const Ray& ray, const EyeRay& eye) {
    hits_.push_back({ray, Hit{}});
    rays_.push_back(eye);
  }
  void find_light(const RayHit& met, const EyeRay& eye, ShadowRays& shadow_rays);
  void pass(const RayHit& ray, const SurfaceInteraction& y, const EyeRay& eye);
  uint32_t max_passes(const EyeRay& eye, uint32_t edges) const;
  void find_arrival(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                    const EyeRay& eye, ShadowRays& shadow_rays) const;
  template <class Function>
  void meet(const SurfaceInteraction& y, const Vec3& d, uint32_t max_passes, const Function& fn);
  void follow(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const EyeRay& eye);
  void go_on(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const EyeRay& eye);
  void connect_point(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                     const EyeRay& eye, ShadowRays& shadow_rays);
  Rgb weighted_bsdf(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const Vec3& wo,
                    const Rgb& f, const EyeRay& eye, bool is_shown = false) const;
  float shown_share(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const Vec3& wo,
                    const EyeRay& eye) const;
  std::span<const float> rates_of(const EyeRay& eye) const {
    return {rates_.data() + tiles_[eye.tile].rates, light_.local->size()};
  }
  float eye_odds(const EyeRay& eye, const SurfaceInteraction& y, const RayHit& ray,
                 const LocalLight::Place& place) const;

  const CellLight& light_;
  const Scene* scene_ = nullptr;
  RenderCounters* counters_ = nullptr;
  LobeValues values_;
  std::vector<RayHit> hits_;
  std::vector<EyeRay> rays_;
  std::vector<RayHit> traced_hits_;  ///< rays that trace() processes
  std::vector<EyeRay> traced_;
  EyeChains chains_;
  std::optional<EyePaths> paths_;  ///< if light bounces several times
  std::vector<Tile> tiles_;        ///< the last is the current tile
  std::vector<float> rates_;
  PointChoice points_;  ///< one block per tile
  // Group of the last send():
  Candidates directions_;
  std::vector<uint32_t> chosen_, numbers_[2];
};

}  // namespace kinome

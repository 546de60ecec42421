#pragma once

#include <optional>
#include <span>
#include <vector>

#include "clustered/product/candidates.h"
#include "clustered/product/cell_light.h"
#include "clustered/product/eye_chains.h"
#include "clustered/product/eye_paths.h"
#include "clustered/product/local_choice.h"
#include "clustered/product/point_choice.h"
#include "clustered/product/shadow_rays.h"

namespace kinome {

/// Rays that each primary of the patch sends by its BSDF toward local light, on average; at most 1.
float expected_eye_rays(const Patch& patch, const LocalLight& light);

/// A direction that the delta lobes of a point mirror to the viewer.
struct MirroredDirection {
  Vec3 d;
  Rgb weight;  ///< of the radiance from there
};
/// Nothing if the BSDF has no delta lobes, or those no direction. u1 chooses between mirroring and
/// what goes through.
std::optional<MirroredDirection> mirrored_direction(const SurfaceInteraction& si, float u1,
                                                    const Vec2& u);

/// Rays that primaries send by their BSDFs: to local light that light points are too near to, and
/// to what mirrors, and lobes too narrow for light points, show. What they find counts by the share
/// of eye rays among all that could have found it. They wait until trace(). One per thread; not
/// thread-safe. `light`, which has local light, must outlive it.
class EyeRays {
 public:
  explicit EyeRays(const CellLight& light) : light_(light), chains_(light), points_(light) {}

  /// The tile that rays to come are sent from, and what it looks at.
  void begin_tile(const Scene& scene, const LocalChoice& choice, uint64_t seed,
                  RenderCounters& counters);

  /// False where no such rays are sent.
  bool applies(const GroupView& group) const;
  /// Some members of the group send a ray, `expected` on average. Random numbers are those of
  /// `seed` and the primaries.
  void send(const GroupView& group, float expected, uint64_t seed, const UnitSums& sums);
  /// The delta lobes of a primary send one, which finds all of their light.
  void send_mirrored(const SurfaceInteraction& si, uint32_t primary, uint64_t seed, Rgb& sum);

  bool empty() const { return rays_.empty(); }
  /// Traces the rays that wait, and the paths that go on from what they meet, and adds what they
  /// find.
  /// Light that arrives where they end is asked for by shadow rays, which are left to wait.
  void trace(ShadowRays& shadow_rays);

 private:
  struct EyeRay {
    Rgb weight;     ///< of the radiance that it finds
    float density;  ///< expected number of such rays, per solid angle; 0: of a delta lobe
    uint32_t tile;  ///< in tiles_
    uint64_t seed;
    Rgb* sum;
    float chain_density = kInfinity;  ///< EyeChains::Begin::density
    uint32_t passes = 0;  ///< surfaces that it has passed straight, and the distance to the last
    float before = 0;
  };
  /// A tile that rays wait for.
  struct Tile {
    size_t rates;  ///< of its choice: where they begin in rates_
    PointChoice::Block points;
  };
  /// An emitter that a ray from a surface meets.
  struct Met {
    std::optional<SurfaceInteraction> x;  ///< nullopt: the sky
    float distance = 0;
    Rgb radiance{0.f};
  };
  void draw(const GroupView& group, uint64_t seed);
  void push(const Ray& ray, const EyeRay& eye);
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
  Rgb eyes_part(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const Vec3& wo,
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
  std::vector<RayHit> traced_hits_;  ///< of trace()
  std::vector<EyeRay> traced_;
  EyeChains chains_;
  std::optional<EyePaths> paths_;  ///< where light comes by more than a bounce
  std::vector<Tile> tiles_;        ///< that rays wait for; the last is this one
  std::vector<float> rates_;
  PointChoice points_;  ///< a block for each tile
  // Of the group that sends:
  Candidates directions_;
  std::vector<uint32_t> chosen_, numbers_[2];
};

}  // namespace kinome

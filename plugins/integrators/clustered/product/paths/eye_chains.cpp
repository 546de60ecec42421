#include "clustered/product/paths/eye_chains.h"

#include <algorithm>

#include "clustered/product/paths/caustics.h"
#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Random numbers of one edge.
enum ChainNumber : uint32_t { kChainLobe, kChainLobeX, kChainLobeY, kChainSurvival };

}  // namespace

/// Sends the next ray of a chain from y. Drops samples that go straight through y if
/// `drops_straight` is set.
void EyeChains::go_on(const SurfaceInteraction& y, const Begin& begin, bool drops_straight) {
  const uint32_t edges = begin.edges;
  const uint64_t own = hash_words(begin.seed, edges);
  const auto sample =
      y.shape->bsdf().sample(y, Lobe::kDelta, random_float(own, kChainLobe),
                             {random_float(own, kChainLobeX), random_float(own, kChainLobeY)});
  if (!sample || is_black(sample->weight)) return;
  if (drops_straight && any(sample->lobe & Lobe::kNull)) return;
  Begin next = begin;
  ++next.edges;
  next.weight *= sample->weight;
  if (edges >= std::min(light_.local->length().rr_depth, Caustics::kMaxSureEdges)) {
    const float survival = survival_probability(next.weight);
    if (!(random_float(own, kChainSurvival) < survival)) return;
    next.weight /= survival;
  }
  rays_.push_back({y.spawn_ray(y.frame.to_world(sample->wo)), Hit{}});
  chains_.push_back(next);
}

/// Adds the light of an emitter that a chain has hit at x (nullptr: the sky). d is the unit
/// direction in which the light leaves.
void EyeChains::add(const Begin& chain, const Emitter& emitter, const SurfaceInteraction* x,
                    const Vec3& d, const Rgb& radiance) const {
  if (is_black(radiance)) return;
  float share = 1;
  if (light_.caustics && chain.density < kInfinity) {
    share =
        light_.caustics->share_of_eye(chain.density, light_.caustics->light_density(emitter, x, d));
  }
  chain.sum[light_.group_of(&emitter)] += chain.weight * radiance * share;
}

void EyeChains::trace(const Scene& scene, RenderCounters& counters) {
  const uint32_t max_depth = light_.local->max_depth();
  while (!rays_.empty()) {
    std::vector<RayHit> rays = std::move(rays_);
    const std::vector<Begin> chains = std::move(chains_);
    rays_.clear();
    chains_.clear();
    for (size_t begin = 0; begin < rays.size(); begin += kEyeRaysPerCall) {
      const size_t count = std::min(kEyeRaysPerCall, rays.size() - begin);
      scene.intersect({&rays[begin], count}, Coherence::kIncoherent, counters);
      counters[RayKind::kBsdf] += count;
    }
    for (size_t i = 0; i < rays.size(); ++i) {
      const Vec3 d = -rays[i].ray.d;
      if (!rays[i].hit.valid()) {
        if (const Emitter* const sky = light_.environment) {
          add(chains[i], *sky, nullptr, d, sky->eval_environment(rays[i].ray.d));
        }
        continue;
      }
      const SurfaceInteraction z = scene.interaction(rays[i]);
      if (const Emitter* const emitter = z.shape->emitter()) {
        add(chains[i], *emitter, &z, d, emitter->eval_surface(z));
      }
      if (chains[i].edges < max_depth && any(z.shape->bsdf().lobes() & Lobe::kDelta)) {
        go_on(z, chains[i], false);
      }
    }
  }
}

}  // namespace kinome

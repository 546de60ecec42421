#pragma once

#include <optional>
#include <vector>

#include "check/emitter_scene.h"
#include "check/receivers.h"

namespace kinome::check {

/// Some rays of light that leave an emitter, by which receivers are put in their way.
struct ProbeRays {
  ProbeRays(const EmitterScene& at, int count, uint64_t seed);

  int tries = 0;
  std::vector<EmissionSample> rays;  ///< that carry light
  bool is_distant = false;           ///< the emitter is infinitely far away
  Vec3 origin{0.f};  ///< mean position at which rays start
  float spread = 0;  ///< largest distance of such a position from `origin`
  Vec3 direction{0, 0, 1};  ///< unit vector of most of the light, or of some ray
};

/// A receiver that catches part of the rays: of light from infinitely far, one that touches the
/// faces of the scene's bounds from within; of other light, one at some distance from the emitter.
Receiver plane_in_the_way(const ProbeRays& probes, const Aabb& bounds);
/// Likewise; around an emitter in the scene, so that all of its light comes by.
Receiver sphere_in_the_way(const ProbeRays& probes, const Aabb& bounds);

/// How a receiver is divided, and where on it light was seen.
struct ReceiverPlan {
  ReceiverPlan(const Receiver& receiver, const ProbeRays& probes, int count);
  ReceiverCells cells;
  ProbeGrid density;
  double expected_hits;
};

/// Flux through the cells of a receiver by `count` rays of sample_emission(): light tracing
/// (Veach 1997, 4.4.3) without obstacles. Front and back are measured separately.
CellFlux flux_by_emission(const Emitter& emitter, const Receiver& receiver,
                          const ReceiverCells& cells, int count, uint64_t seed);

/// The same by `count` points of the receiver, each with one sample of sample_direct(). Adds the
/// differences of two emitters at the same points, by the same numbers, where `minus` is not
/// nullptr.
CellFlux flux_by_sample_direct(const Emitter& emitter, const Receiver& receiver,
                               const ReceiverPlan& plan, int count, uint64_t seed,
                               const Emitter* minus = nullptr);

}  // namespace kinome::check

#pragma once

#include <optional>
#include <vector>

#include "kit/scenes/emitter_scene.h"
#include "kit/scenes/receivers.h"

namespace kinome::check {

/// Some rays of light from an emitter. Receivers are placed in their way.
struct ProbeRays {
  ProbeRays(const EmitterScene& at, int count, uint64_t seed);

  int tries = 0;
  std::vector<EmissionSample> rays;  ///< rays that carry light
  bool is_distant = false;           ///< the emitter is infinitely far away
  Vec3 origin{0.f};  ///< mean position at which rays start
  float spread = 0;  ///< largest distance of such a position from `origin`
  Vec3 direction{0, 0, 1};  ///< mean direction, or that of some ray if the directions cancel
};

/// Returns a rectangle that part of the rays hit. For light from infinitely far, it is a face of
/// the scene's bounds; otherwise, it is at some distance from the emitter.
Receiver plane_in_the_way(const ProbeRays& probes, const Aabb& bounds);
/// Returns a sphere that the rays hit. For light from infinitely far, it is the largest one in the
/// scene's bounds; otherwise, it surrounds the emitter, so that all light crosses it.
Receiver sphere_in_the_way(const ProbeRays& probes, const Aabb& bounds);

/// The cells of a receiver, and the density of its points by where the probe rays hit.
struct ReceiverPlan {
  ReceiverPlan(const Receiver& receiver, const ProbeRays& probes, int count);
  ReceiverCells cells;
  ProbeGrid density;
  double expected_hits;
};

/// Estimates the flux through the cells of a receiver with `count` rays of sample_emission(): light
/// tracing (Veach 1997, 4.4.3) without obstacles. Measures front and back separately.
CellFlux flux_by_emission(const Emitter& emitter, const Receiver& receiver,
                          const ReceiverCells& cells, int count, uint64_t seed);

/// Estimates the same flux at `count` points of the receiver, with one sample of sample_direct()
/// each. If `minus` isn't nullptr, subtracts the flux of this emitter, estimated at the same points
/// with the same random numbers.
CellFlux flux_by_sample_direct(const Emitter& emitter, const Receiver& receiver,
                               const ReceiverPlan& plan, int count, uint64_t seed,
                               const Emitter* minus = nullptr);

}  // namespace kinome::check

#pragma once

#include "kinome/wide/functions.h"

namespace kinome::transport {

/// Draws a channel, 0 to 2, in proportion to `throughput`, with the random number u in [0, 1).
/// Never draws a channel without throughput, in spite of rounding, unless all are 0. V is
/// kinome::Rgb, or wide::Rgb for one draw in each lane.
template <class V>
KINOME_WIDE wide::IntOf<wide::NumberOf<V>> draw_channel(const V& throughput, wide::NumberOf<V> u) {
  using namespace wide;
  using F = NumberOf<V>;
  using I = IntOf<F>;
  const F two = throughput.x + throughput.y;
  const F at = u * (two + throughput.z);
  const I last = select(throughput.z > F(0), I(2), select(throughput.y > F(0), I(1), I(0)));
  return select(at < throughput.x, I(0), select(at < two, I(1), last));
}

/// Returns component `channel` of v.
KINOME_WIDE wide::Float component(wide::Vec3 v, wide::Int channel) {
  return select(channel == 0, v.x, select(channel == 1, v.y, v.z));
}

/// Returns the factor of the throughput for a segment of length d in a medium whose channels
/// differ, and for the collision at its end where `collides` is true. Distances are sampled by the
/// extinction of `channel`.
KINOME_WIDE wide::Rgb segment_weight(wide::Rgb throughput, wide::Rgb extinction, wide::Rgb albedo,
                                     wide::Int channel, wide::Float d, wide::Mask collides) {
  using namespace wide;
  // Relative to the sampled channel, so that exponentials can't all be 0.
  const wide::Vec3 excess = wide::Vec3(component(extinction, channel)) - extinction;
  const wide::Rgb transmittance(exp(excess.x * d), exp(excess.y * d), exp(excess.z * d));
  const wide::Rgb density = transmittance * select(collides, extinction, wide::Rgb(1.f));
  const wide::Rgb value = density * select(collides, albedo, wide::Rgb(1.f));
  const Float sum = throughput.x + throughput.y + throughput.z;
  return value * (sum / dot(throughput, density));
}

}  // namespace kinome::transport

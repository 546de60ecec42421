#pragma once

#include "kinome/wide/vectors.h"

namespace kinome::transport {

/// Draws a channel, 0 to 2, in proportion to `throughput`, with the random number u in [0, 1).
/// Never draws a channel without throughput, in spite of rounding, unless all are 0. For
/// kinome::Rgb, or wide::Rgb with one draw in each lane.
template <class V>
KINOME_WIDE wide::IntOf<wide::NumberOf<V>> draw_channel(const V& throughput,
                                                        wide::NumberOf<V> u) {
  using namespace wide;
  using F = NumberOf<V>;
  using I = IntOf<F>;
  const F two = throughput.x + throughput.y;
  const F at = u * (two + throughput.z);
  const I last = select(throughput.z > F(0), I(2), select(throughput.y > F(0), I(1), I(0)));
  return select(at < throughput.x, I(0), select(at < two, I(1), last));
}

}  // namespace kinome::transport

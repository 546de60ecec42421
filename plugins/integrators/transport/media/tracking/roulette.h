#pragma once

#include "kinome/wide/functions.h"

namespace kinome::transport {

/// Returns the weight to which Russian roulette raises paths of n collisions: 1 up to `long_path`
/// collisions, then n / long_path. A path continues with the probability throughput / weight.
///
/// Without absorption, a fraction of about 1 / sqrt(n) of the paths into a body takes n collisions
/// or more, up to the square of the optical depth τ of the body. Roulette by the throughput alone
/// never ends them. With a constant probability, as in Mitsuba, weights grow exponentially, so that
/// renders hardly ever contain the rare paths that carry the rest of the light. With this weight,
/// roulette adds a relative variance of about τ / long_path, and the mean number of steps is at
/// most about 4 sqrt(long_path) for any τ.
template <class F>
KINOME_WIDE F weight_of_length(F n, float long_path) {
  using namespace wide::formulas;
  return max(n / long_path, F(1.f));
}

}  // namespace kinome::transport

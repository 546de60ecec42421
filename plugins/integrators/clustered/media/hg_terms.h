#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/wide/functions.h"

namespace kinome {

/// Henyey-Greenstein function relative to an isotropic one, times a factor, with the terms that
/// don't depend on the direction. For importances: it is bounded near the peaks of narrow lobes,
/// where rounding errors dominate. wide::henyey_greenstein() is precise there, too. F is float or
/// wide::Float.
template <class F>
struct HgTerms {
  F base, slope, weight;

  static HgTerms of(const F& g, const F& factor) {
    return {1.f + g * g, 2.f * g, factor * (1.f - g * g)};
  }
  /// `cosine`: of the deflection; 1 is straight on.
  F at(const F& cosine) const {
    using std::max, std::sqrt;
    constexpr float kMinBase = 1e-6f;
    const F d = max(base - slope * cosine, F(kMinBase));
    return weight / (d * sqrt(d));
  }
};

}  // namespace kinome

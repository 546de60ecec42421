#pragma once

#include <cmath>
#include <cstdint>

#include "kinome/math.h"
#include "kinome/sampler.h"

namespace kinome::check {

/// Reproducible random numbers.
class Random {
 public:
  explicit Random(uint64_t seed) : seed_(seed) {}
  float unit() { return to_unit_float(static_cast<uint32_t>(hash_words(seed_, counter_++))); }
  float between(float lo, float hi) { return lo + (hi - lo) * unit(); }
  Vec2 unit2() {
    const float x = unit();
    return {x, unit()};
  }
  /// Returns a direction that is uniformly distributed over the sphere.
  Vec3 direction() {
    const float z = between(-1, 1);
    const float phi = between(0, 2 * kPi);
    const float r = safe_sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  uint64_t seed_;
  uint64_t counter_ = 0;
};

}  // namespace kinome::check

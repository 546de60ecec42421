#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "kinome/math.h"
#include "kinome/sampler.h"

namespace kinome::test {

/// Random choices for one scene.
class Dice {
 public:
  Dice(uint64_t seed, uint64_t index) : seed_(hash_words(seed, index)) {}
  uint64_t bits() { return hash_words(seed_, count_++); }
  float unit() { return to_unit_float(static_cast<uint32_t>(bits() >> 32)); }
  float between(float low, float high) { return low + (high - low) * unit(); }
  int below(int count) { return static_cast<int>(bits() % static_cast<uint64_t>(count)); }
  bool chance(double p) { return unit() < p; }
  /// Returns a log-uniform value in 10^[low, high].
  double decades(float low, float high) { return std::pow(10., between(low, high)); }
  template <class T>
  const T& of(const std::vector<T>& choices) {
    return choices[static_cast<size_t>(below(static_cast<int>(choices.size())))];
  }
  Vec3 direction() {
    const float z = between(-1, 1), phi = between(0, 2 * kPi), r = safe_sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  Vec3 in_cube(float half) {
    const float x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  uint64_t seed_;
  uint64_t count_ = 0;
};

}  // namespace kinome::test

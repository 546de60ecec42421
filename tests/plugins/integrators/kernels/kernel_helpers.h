#pragma once

#include <random>

#include "kinome/warp.h"

namespace kinome::test {

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  float unit() { return static_cast<float>(rng_() >> 8) * 0x1p-24f; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  Vec3 direction() { return square_to_uniform_sphere({unit(), unit()}); }

 private:
  std::mt19937 rng_;
};

}  // namespace kinome::test

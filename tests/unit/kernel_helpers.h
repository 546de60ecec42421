#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "instruction_sets.h"
#include "kinome/warp.h"

namespace kinome::test {

/// Runs `test` with the kernels of each instruction set that this machine has.
inline void with_all_kernels(const std::function<void()>& test) {
  for_each_instruction_set(test);
}

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

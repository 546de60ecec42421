#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <optional>

#include "kinome/block_points.h"
#include "kinome/emitter.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/texture.h"
#include "support/block_memory.h"

/// Values that are hashes of their arguments, for tests of default block functions.
namespace kinome::test::default_blocks {

/// Returns a hash of the values in [0, 1). Any change of a value changes it.
template <class... Numbers>
float mixed(Numbers... numbers) {
  uint64_t bits = 0;
  ((bits = hash_words(bits, std::bit_cast<uint32_t>(static_cast<float>(numbers)))), ...);
  return to_unit_float(static_cast<uint32_t>(bits));
}
template <class... Numbers>
Vec3 mixed_vector(Numbers... numbers) {
  return {mixed(1, numbers...), mixed(2, numbers...), mixed(3, numbers...)};
}

/// Columns of random values, with NaN in their padding.
class Given {
 public:
  explicit Given(size_t count) : count_(count), memory_(count) {}

  float* one() {
    float* const column = memory_.one();
    ++columns_;
    for (size_t i = 0; i < count_; ++i) column[i] = mixed(columns_, i);
    return column;
  }
  Columns2 two() { return {one(), one()}; }
  Columns3 three() { return {one(), one(), one()}; }
  /// Returns surface points without shapes.
  SurfaceBlock points() {
    SurfaceBlock points;
    points.count = count_;
    for (Columns3* columns : {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.dp_du,
                              &points.dp_dv, &points.wi}) {
      *columns = three();
    }
    points.uv = two();
    points.p_error = one();
    points.primitive = memory_.indices(), points.ray = memory_.indices();
    for (size_t i = 0; i < count_; ++i) {
      points.primitive[i] = static_cast<uint32_t>(7 * i);
      points.ray[i] = static_cast<uint32_t>(count_ - 1 - i);
    }
    shapes_.assign(padded(count_), nullptr);
    points.shape = shapes_.data();
    return points;
  }

 private:
  size_t count_;
  BlockMemory memory_;
  std::vector<const Shape*> shapes_;
  int columns_ = 0;
};

}  // namespace kinome::test::default_blocks

#pragma once

#include "kinome/wide/vectors.h"

// Part of the kernels: vectors whose coordinates are three columns.
namespace kinome::simd {

/// Loads vectors i, i + 1 ...
KINOME_WIDE wide::Vec3 load(const float* x, const float* y, const float* z, size_t i) {
  using wide::Float;
  return {Float::load(x + i), Float::load(y + i), Float::load(z + i)};
}
KINOME_WIDE wide::Vec3 load(const float* const (&columns)[3], size_t i) {
  return load(columns[0], columns[1], columns[2], i);
}

}  // namespace kinome::simd

#pragma once

#include "kinome/wide/vectors.h"
#include "transport/surfaces/vertices.h"

/// Functions that the parts of DirectLight share.
namespace kinome::transport {

/// Returns the weight of a sample from a technique of density a > 0 if another technique has
/// density b. The formula uses the ratio of the densities to avoid overflow and 0 / 0.
template <class F>
KINOME_WIDE F power_heuristic(F a, F b) {
  const F ratio = b / a;
  return 1.f / (1.f + ratio * ratio);
}

/// True for points i … that aren't padding.
KINOME_WIDE wide::Mask is_live(const Surfaces& surfaces, size_t i) {
  return wide::Float::load(surfaces.live() + i) > 0.f;
}

KINOME_WIDE wide::Rgb throughput(const Vertices& vertices, size_t i) {
  return vertices.throughput.x ? wide::Rgb::load(vertices.throughput, i) : wide::Rgb(1.f);
}

}  // namespace kinome::transport

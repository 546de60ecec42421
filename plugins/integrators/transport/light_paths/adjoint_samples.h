#pragma once

#include "transport/surfaces/shading.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Next edges of light paths for blocks of points, as sampled by sample_adjoint() with all lobes.
/// Reuses its memory. Not thread-safe: use one per thread.
class AdjointSamples {
 public:
  /// Allocates memory for blocks of at most `points` points, padding included.
  explicit AdjointSamples(size_t points);

  /// Samples a direction at each reflecting point of `met`. Sets `wo`, `sample_pdf` and `is_delta`
  /// of the result as a BSDF does, and `weight` for power. The result is valid until the next call.
  const BsdfAnswer& sample(const Surfaces& met, float* u1, const Columns2& u2);

 private:
  void turn_to_viewers(const Surfaces& met, const Surfaces::Range& range, const float* u1,
                       const Columns2& u2);
  void bend(const Surfaces& met, const Surfaces::Range& range);

  Arena arena_;
  BsdfAnswer sampled_, seen_;
};

}  // namespace kinome::transport

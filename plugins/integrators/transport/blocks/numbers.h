#pragma once

#include "kinome/sampler.h"
#include "transport/blocks/arena.h"

namespace kinome::transport {

/// Returns the key of sample number `sample` of a block.
SampleKey key_of(const PixelSamples& samples, uint32_t sample);

/// Random numbers for points. Each point gets the numbers of the sample that it belongs to. Not
/// thread-safe: use one per thread.
class Numbers {
 public:
  explicit Numbers(size_t samples);

  /// Sets the numbers of `count` points, whose samples are `owner`, in one dimension of the sampler
  /// (fill_1d) or two (fill_2d).
  void fill_1d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
               const uint32_t* owner, size_t count, float* out);
  void fill_2d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
               const uint32_t* owner, size_t count, const Columns2& out);

 private:
  Arena arena_;
  Columns2 all_;
};

}  // namespace kinome::transport

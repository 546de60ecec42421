#pragma once

#include "arena.h"
#include "kinome/sampler.h"

namespace kinome::transport {

/// Of sample number `sample` of a block.
SampleKey key_of(const PixelSamples& samples, uint32_t sample);

/// Random numbers for points: each has those of the sample of the block that it belongs to. One per
/// thread.
class Numbers {
 public:
  explicit Numbers(size_t samples);

  /// For `count` points, whose samples are `owner`, in a dimension (or two) of the sampler.
  void fill_1d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
               const uint32_t* owner, size_t count, float* out);
  void fill_2d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
               const uint32_t* owner, size_t count, const Columns2& out);

 private:
  Arena arena_;
  Columns2 all_;
};

}  // namespace kinome::transport

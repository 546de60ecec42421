#pragma once

#include "transport/blocks/numbers.h"

namespace kinome::transport {

/// Seeds of random numbers in addition to the sampler's, for an unknown number of events along a
/// ray. Each seed depends only on the sample and on its use.
class RandomSeeds {
 public:
  RandomSeeds(const PixelSamples& samples, uint32_t use) : samples_(samples), use_(use) {}

  /// Returns the seed of a sample of the block.
  uint64_t of(uint32_t sample) const {
    const SampleKey key = key_of(samples_, sample);
    return hash_words(key.seed, uint64_t{key.x} << 32 | key.y, uint64_t{key.sample} << 32 | use_,
                      legs_);
  }
  /// Returns the seeds for another part of the same ray.
  RandomSeeds after(uint32_t legs) const {
    RandomSeeds later = *this;
    later.legs_ = legs;
    return later;
  }

 private:
  const PixelSamples& samples_;
  uint32_t use_;
  uint32_t legs_ = 0;
};

}  // namespace kinome::transport

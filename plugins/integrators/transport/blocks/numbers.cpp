#include "transport/blocks/numbers.h"

#include "kinome/wide/near_indices.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// True if it is cheaper to compute the points' numbers one by one than those of the whole block.
bool are_few(size_t count, const PixelSamples& samples) {
  constexpr size_t kShare = 16;
  return count * kShare < samples.count();
}

}  // namespace

SampleKey key_of(const PixelSamples& samples, uint32_t sample) {
  const uint32_t pixel = sample / samples.samples;
  return {samples.x[pixel], samples.y[pixel], samples.first_sample + sample % samples.samples,
          samples.seed};
}

Numbers::Numbers(size_t samples) : arena_(samples), all_(arena_.two()) {}

void Numbers::fill_1d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                      const uint32_t* owner, size_t count, float* out) {
  if (are_few(count, samples)) {
    for (size_t i = 0; i < count; ++i) {
      out[i] = sampler.value_1d(key_of(samples, owner[i]), dimension);
    }
    return;
  }
  sampler.fill_1d_block(samples, dimension, all_.x);
  for_lanes(count, [&](size_t i) { NearIndices(owner + i).in(all_.x).store(out + i); });
}

void Numbers::fill_2d(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                      const uint32_t* owner, size_t count, const Columns2& out) {
  if (are_few(count, samples)) {
    for (size_t i = 0; i < count; ++i) {
      out.set(i, sampler.value_2d(key_of(samples, owner[i]), dimension));
    }
    return;
  }
  sampler.fill_2d_block(samples, dimension, all_);
  for_lanes(count, [&](size_t i) { NearIndices(owner + i).in(all_).store(out, i); });
}

}  // namespace kinome::transport

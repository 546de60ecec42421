#pragma once

#include <vector>

#include "clustered/media/fog_block.h"
#include "kinome/math.h"
#include "volume_scenes.h"

namespace kinome::test {

/// Mean and variance of the mean of the sum of a block's radiance, for each channel, over `blocks`
/// blocks of 128 samples of 2 x 2 pixels. Their seeds are first_seed, first_seed + 1, ...
inline std::vector<Estimate> radiance_of(FogBlock& block, int blocks, uint64_t first_seed) {
  check::Moments moments[3];
  for (int i = 0; i < blocks; ++i) {
    const uint32_t x[] = {0, 1, 0, 1}, y[] = {0, 0, 1, 1};
    const PixelSamples samples{x, y, 4, 0, 128, first_seed + static_cast<uint64_t>(i)};
    RenderCounters counters;
    block.trace(samples, counters);
    for (int c = 0; c < 3; ++c) {
      double value = 0;
      for (size_t k = 0; k < samples.count(); ++k) value += block.radiance().at(k)[c];
      moments[c].add(value);
    }
  }
  std::vector<Estimate> result;
  for (const check::Moments& m : moments) result.push_back({m.mean(), m.variance_of_mean()});
  return result;
}

}  // namespace kinome::test

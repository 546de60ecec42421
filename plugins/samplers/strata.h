#pragma once

#include <algorithm>

#include "permutation.h"
#include "sampler_common.h"

namespace kinome {

/// Apart in `salt`: of a number alone, and of a pair, at one dimension.
inline constexpr uint32_t kOneDimension = 0, kTwoDimensions = 1u << 31;

/// Where a sample lies in its set of `count`, which follow one another without end.
struct StratumPlace {
  uint32_t stratum;  ///< in [0, count), each taken once
  Vec2 jitter;
  uint64_t hash;  ///< of the set
};
inline StratumPlace stratum_of(const SampleKey& key, uint32_t count, uint32_t salt) {
  const uint32_t set = key.sample / count, within = key.sample % count;
  const uint64_t hash = hash_key(key, set, salt);
  return {permute(within, count, hash),
          to_unit_square(scatter(hash + within * 0xd1342543de82ef95u + 1)), hash};
}

/// In [0,1), `jitter` from one end of the stratum to the other.
inline float in_stratum(uint32_t stratum, float jitter, uint32_t count) {
  const float value = (static_cast<float>(stratum) + jitter) / static_cast<float>(count);
  return std::min(value, kOneMinusEpsilon);
}

}  // namespace kinome

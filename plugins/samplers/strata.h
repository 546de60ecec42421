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
/// `jitters`: else each sample lies in the middle of its stratum.
inline StratumPlace stratum_of(const SampleKey& key, uint32_t count, uint32_t salt,
                               bool jitters = true) {
  const uint32_t set = key.sample / count, within = key.sample % count;
  const uint64_t hash = hash_key(key, set, salt);
  const uint64_t own = scatter(hash + within * 0xd1342543de82ef95u + 1);
  return {permute(within, count, hash), jitters ? to_unit_square(own) : Vec2(0.5f), hash};
}

/// The row of the tables of samplers that may do without jitter.
inline constexpr Parameter kJitter{"jitter", ParameterType::kBoolean, "true",
                                   "false: each sample in the middle of its stratum"};

/// In [0,1), `jitter` from one end of the stratum to the other.
inline float in_stratum(uint32_t stratum, float jitter, uint32_t count) {
  const float value = (static_cast<float>(stratum) + jitter) / static_cast<float>(count);
  return std::min(value, kOneMinusEpsilon);
}

}  // namespace kinome

#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>

#include "kinome/properties.h"
#include "kinome/sampler.h"

namespace kinome {

/// Parameters of every sampler.
#define KINOME_SAMPLER_PARAMETERS                                      \
  {"sample_count", ParameterType::kInteger, "4",                       \
   "samples per pixel, rounded up as the method requires"},            \
  {                                                                    \
    "seed", ParameterType::kInteger, "0", "seed of the random numbers" \
  }

inline constexpr uint32_t kMaxSampleCount = 1u << 30;

inline uint32_t read_sample_count(const Properties& props) {
  return props.integer("sample_count", 1, kMaxSampleCount);
}

/// Warns if `requested` was rounded up, as Mitsuba does.
inline void warn_if_rounded(const Properties& props, uint32_t requested, uint32_t count) {
  if (count != requested) props.warn("sample_count", "is rounded up to " + std::to_string(count));
}

/// Base of samplers with any number of samples. Self has the same constructors.
template <class Self>
class CountedSampler : public Sampler {
 public:
  explicit CountedSampler(const Properties& props)
      : CountedSampler(read_sample_count(props), static_cast<uint64_t>(props.integer("seed"))) {}
  CountedSampler(uint32_t count, uint64_t seed) {
    sample_count_ = count;
    seed_ = seed;
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Self>(count, seed_);
  }
};

/// Returns 64 random bits for a counter: the two halves of the 128-bit product of the counter and a
/// variation of it, combined by exclusive or.
inline uint64_t scatter(uint64_t counter) {
  __extension__ using uint128 = unsigned __int128;
  const uint128 product = static_cast<uint128>(counter) * (counter ^ 0xe7037ed1a0b428dbu);
  return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
}

/// Returns 64 random bits for a pixel of a render. x and y are multiplied separately: reading both
/// as one 64-bit word just after they were written would fail store forwarding, which costs 13 ns.
inline uint64_t hash_pixel(const SampleKey& key) {
  return scatter(key.x * 0xa0761d6478bd642fu + key.y * 0x8ebc6af09c88c6e3u + key.seed);
}
/// Returns 64 random bits for a pixel and two more words.
inline uint64_t hash_key(const SampleKey& key, uint32_t a, uint32_t b) {
  return scatter(hash_pixel(key) + a * 0x9e3779b97f4a7c15u + b * 0xd1342543de82ef95u);
}

}  // namespace kinome

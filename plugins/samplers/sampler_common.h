#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "kinome/properties.h"
#include "kinome/sampler.h"

namespace kinome {

/// Rows of a parameter table that every sampler has.
#define KINOME_SAMPLER_PARAMETERS                                                       \
  {"sample_count", ParameterType::kInteger, "4",                                        \
   "samples a pixel, rounded up as the method needs"},                                  \
  {                                                                                     \
    "seed", ParameterType::kInteger, "0", "another seed, another set of random numbers" \
  }

inline constexpr uint32_t kMaxSampleCount = 1u << 30;

inline uint32_t read_sample_count(const Properties& props) {
  return props.integer("sample_count", 1, kMaxSampleCount);
}

/// Says that `wanted` was rounded, as Mitsuba does.
inline void warn_if_rounded(const Properties& props, uint32_t wanted, uint32_t count) {
  if (count != wanted) props.warn("sample_count", "is rounded up to " + std::to_string(count));
}

/// 64 random bits from a counter: both halves of a product of the counter with a variation of
/// itself, folded. Passes through one wide multiplication, and neither factor is ever fixed.
inline uint64_t scatter(uint64_t counter) {
  __extension__ using uint128 = unsigned __int128;
  const uint128 product = static_cast<uint128>(counter) * (counter ^ 0xe7037ed1a0b428dbu);
  return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
}

/// 64 random bits for a pixel of a render. x and y have a factor each: read as one word of 64 bits,
/// a key that was just written costs a failed store forwarding, 13 ns.
inline uint64_t hash_pixel(const SampleKey& key) {
  return scatter(key.x * 0xa0761d6478bd642fu + key.y * 0x8ebc6af09c88c6e3u + key.seed);
}
/// 64 random bits for two more words.
inline uint64_t hash_key(const SampleKey& key, uint32_t a, uint32_t b) {
  return scatter(hash_pixel(key) + a * 0x9e3779b97f4a7c15u + b * 0xd1342543de82ef95u);
}

}  // namespace kinome

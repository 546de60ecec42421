#pragma once

#include <cstdint>

namespace kinome {

inline uint32_t reverse_bits(uint32_t v) {
#if defined(__clang__)
  return __builtin_bitreverse32(v);
#else
  v = __builtin_bswap32(v);
  v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
  v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
  return (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
#endif
}

/// Owen's nested uniform scramble of a number whose bits are reversed: whether a bit flips is a
/// random function of `key` and of the bits below it. After Laine and Karras 2011 ("Stratified
/// sampling for stochastic transparency") in Burley's use of it (2020, "Practical hash-based Owen
/// scrambling"): additions and multiplications carry only upward. The even constants are our own,
/// searched for flips that are even odds for every pair of bits, to 3 %.
inline uint32_t scramble_reversed(uint32_t v, uint64_t key) {
  const auto low = static_cast<uint32_t>(key);
  const auto high = static_cast<uint32_t>(key >> 32);
  v += low;
  v ^= v * 0xb56cdf08u;
  v *= high | 1;
  v ^= v * 0xe26b9edeu;
  v += high >> 3;
  v ^= v * 0xc696ff2eu;
  return v ^ v * 0xf0ccfb66u;
}

/// Owen's nested uniform scramble: a bit flips depending on the bits above it.
inline uint32_t owen_scramble(uint32_t v, uint64_t key) {
  return reverse_bits(scramble_reversed(reverse_bits(v), key));
}

}  // namespace kinome

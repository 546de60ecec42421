#pragma once

#include <cstdint>

#include "kinome/sampler.h"

namespace kinome {

// The templates take U = uint32_t, or the vectors of integers of kinome/wide.

namespace bits {
template <int n>
constexpr uint32_t shift_left(uint32_t v) {
  return v << n;
}
template <int n>
constexpr uint32_t shift_right(uint32_t v) {
  return v >> n;
}
}  // namespace bits

/// Reverses the order of the bits.
template <class U>
U reverse_bits(U v) {
  using bits::shift_left, bits::shift_right;
  v = shift_right<16>(v) | shift_left<16>(v);
  v = (shift_right<8>(v) & 0x00ff00ffu) | shift_left<8>(v & 0x00ff00ffu);
  v = (shift_right<4>(v) & 0x0f0f0f0fu) | shift_left<4>(v & 0x0f0f0f0fu);
  v = (shift_right<2>(v) & 0x33333333u) | shift_left<2>(v & 0x33333333u);
  return (shift_right<1>(v) & 0x55555555u) | shift_left<1>(v & 0x55555555u);
}
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

/// Bijective mixing of 32 bits: flipping a bit of v flips each bit of the result with a probability
/// near one half. Uses only 32-bit products, which vectors support. Multipliers: Wellons 2018,
/// "Prospecting for hash functions".
template <class U>
U mix_32(U v) {
  using bits::shift_right;
  v ^= shift_right<16>(v);
  v *= 0x21f0aaadu;
  v ^= shift_right<15>(v);
  v *= 0x735a2d97u;
  return v ^ shift_right<15>(v);
}

/// Owen's nested uniform scrambling of a number with reversed bits: whether a bit flips is a random
/// function of the key and the bits below it. After Laine and Karras 2011 ("Stratified sampling for
/// stochastic transparency") as used by Burley 2020 ("Practical hash-based Owen scrambling"):
/// additions and multiplications carry only upward. The even constants are our own, found by a
/// search: each bit affects each bit above it with a probability of one half, to within 3 %.
template <class U>
U scramble_reversed(U v, U key_low, U key_high) {
  using bits::shift_right;
  v += key_low;
  v ^= v * 0xb56cdf08u;
  v *= key_high | 1u;
  v ^= v * 0xe26b9edeu;
  v += shift_right<3>(key_high);
  v ^= v * 0xc696ff2eu;
  return v ^ (v * 0xf0ccfb66u);
}
inline uint32_t scramble_reversed(uint32_t v, uint64_t key) {
  return scramble_reversed(v, static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32));
}

/// Owen's nested uniform scrambling: whether a bit flips depends on the bits above it.
inline uint32_t owen_scramble(uint32_t v, uint64_t key) {
  return reverse_bits(scramble_reversed(reverse_bits(v), key));
}

/// Second dimension of the Sobol sequence, with reversed bits (the least significant bit is the
/// half). Its matrix is Pascal's triangle modulo 2, the tensor power of (1 1; 0 1), so that five
/// steps replace 32 direction numbers.
template <class U>
U sobol_second_reversed(U index) {
  using bits::shift_right;
  index ^= shift_right<1>(index) & 0x55555555u;
  index ^= shift_right<2>(index) & 0x33333333u;
  index ^= shift_right<4>(index) & 0x0f0f0f0fu;
  index ^= shift_right<8>(index) & 0x00ff00ffu;
  return index ^ shift_right<16>(index);
}

/// Points of the first two Sobol dimensions, a (0, 2)-sequence in base 2, with each dimension
/// scrambled by its own key. The first dimension is the bit-reversed index, so scrambling needs
/// only one reversal.
inline float owen_sobol_first(uint32_t index, uint64_t key) {
  return to_unit_float(reverse_bits(scramble_reversed(index, key)));
}
inline Vec2 owen_sobol_point(uint32_t index, uint64_t key_x, uint64_t key_y) {
  return {owen_sobol_first(index, key_x), owen_sobol_first(sobol_second_reversed(index), key_y)};
}

}  // namespace kinome

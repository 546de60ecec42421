#pragma once

// Integer functions of samplers, for uint32_t and wide::Uint.

#include <algorithm>
#include <cstdint>

#include "kinome/wide/owen.h"
#include "kinome/wide/random.h"

namespace kinome {

/// Same as in owen.h, by table lookups of 4 bits: a third of the instructions.
KINOME_WIDE wide::Uint reverse_bits(wide::Uint v) {
#if HWY_TARGET == HWY_SCALAR
  return kinome::reverse_bits(wide::hn::GetLane(v.v));
#elif HWY_TARGET == HWY_EMU128
  return reverse_bits<wide::Uint>(v);
#else
  namespace hn = wide::hn;
  using ByteTag = hn::Repartition<uint8_t, wide::UintTag>;
  constexpr ByteTag bytes;
  alignas(16) static constexpr uint8_t kReversed[16] = {0, 8, 4, 12, 2, 10, 6, 14,
                                                        1, 9, 5, 13, 3, 11, 7, 15};
  alignas(16) static constexpr uint8_t kBackward[16] = {3,  2,  1, 0, 7,  6,  5,  4,
                                                        11, 10, 9, 8, 15, 14, 13, 12};
  const auto reversed = hn::LoadDup128(bytes, kReversed);
  const auto half = hn::Set(bytes, uint8_t{15});
  const auto low = hn::And(hn::BitCast(bytes, v.v), half);
  const auto high = hn::And(hn::BitCast(bytes, hn::ShiftRight<4>(v.v)), half);
  // Looked-up values have 4 bits, so the shift stays within the byte.
  const auto of_low = hn::BitCast(
      bytes, hn::ShiftLeft<4>(hn::BitCast(wide::UintTag(), hn::TableLookupBytes(reversed, low))));
  const auto both = hn::Or(of_low, hn::TableLookupBytes(reversed, high));
  const auto backward = hn::LoadDup128(bytes, kBackward);
  return wide::Uint(hn::BitCast(wide::UintTag(), hn::TableLookupBytes(both, backward)));
#endif
}

constexpr bool is_prime(uint32_t n) {
  for (uint32_t i = 2; i * i <= n; ++i) {
    if (n % i == 0) return false;
  }
  return n >= 2;
}

/// Returns the upper 32 bits of the product.
inline uint32_t multiply_high(uint32_t a, uint32_t b) {
  return static_cast<uint32_t>(static_cast<uint64_t>(a) * b >> 32);
}
KINOME_WIDE wide::Uint multiply_high(wide::Uint a, wide::Uint b) {
  namespace hn = wide::hn;
#if HWY_TARGET == HWY_SCALAR
  return multiply_high(hn::GetLane(a.v), hn::GetLane(b.v));
#else
  constexpr hn::RepartitionToWide<wide::UintTag> pairs;
  const auto odd = [&](wide::Uint v) {
    return hn::BitCast(wide::UintTag(), hn::ShiftRight<32>(hn::BitCast(pairs, v.v)));
  };
  const auto of_even = hn::ShiftRight<32>(hn::MulEven(a.v, b.v));
  const auto of_odd = hn::MulEven(odd(a), odd(b));
  return wide::Uint(
      hn::OddEven(hn::BitCast(wide::UintTag(), of_odd), hn::BitCast(wide::UintTag(), of_even)));
#endif
}

template <class U>
struct Division {
  U quotient, remainder;
};

/// Arithmetic modulo a fixed number from 1 to 2^24, without division instructions.
class Modulus {
 public:
  constexpr explicit Modulus(uint32_t number)
      : number_(number),
        reciprocal_(static_cast<uint32_t>(std::min<uint64_t>((uint64_t{1} << 32) / number, ~0u))),
        inverse_((1 - 0x1p-21f) / static_cast<float>(number)),
        scale_(static_cast<float>(number) * 0x1p-24f) {}

  constexpr uint32_t number() const { return number_; }

  template <class U>
  KINOME_WIDE Division<U> divide(U a) const {
    return corrected(a, multiply_high(a, U(reciprocal_)));
  }
  /// Same as divide(), in half the time, for a < 2^31 with a quotient below 2^20.
  template <class U>
  KINOME_WIDE Division<U> divide_small(U a) const {
    using namespace wide::formulas;
    return corrected(a, as_uint(to_int(to_float(as_int(a)) * inverse_)));
  }
  /// Adds two numbers below number(), modulo number().
  template <class U>
  KINOME_WIDE U add(U a, U b) const {
    using namespace wide::formulas;
    const U sum = a + b;
    return min(sum, sum - U(number_));  // the difference wraps around if sum < number_
  }
  /// Returns a random number below number(), from 32 random bits. Probabilities differ relatively
  /// by at most number() / 2^24.
  template <class U>
  KINOME_WIDE U random(U bits) const {
    using namespace wide::formulas;
    return as_uint(to_int(to_float(as_int(wide::shift_right<8>(bits))) * scale_));
  }

 private:
  /// `quotient` is correct or too small by 1, because reciprocals are rounded down.
  template <class U>
  KINOME_WIDE Division<U> corrected(U a, U quotient) const {
    using namespace wide::formulas;
    const U remainder = a - quotient * U(number_);
    const U reduced = remainder - U(number_);  // wraps around if the quotient is correct
    return {select(reduced < remainder, quotient + U(1u), quotient), min(remainder, reduced)};
  }

  uint32_t number_;
  uint32_t reciprocal_;
  float inverse_;
  float scale_;
};

}  // namespace kinome

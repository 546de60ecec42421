// Halton points, Owen-scrambled in each pixel. Dimension d is the radical inverse of the sample's
// index in base b, the d-th prime. The permutation of a digit depends on the digits before it (Owen
// 1995, "Randomly permuted (t,m,s)-nets"). Permutations are random linear ones, (a digit + c)
// modulo b, which give pairs of points the same distribution as random permutations, and thus the
// same variance (Matoušek 1998). Any prefix is evenly spread; b^k samples stratify a dimension
// perfectly.
//
//   <sampler type="halton"><integer name="sample_count" value="64"/></sampler>

#include <array>
#include <utility>

#include "kinome/plugin.h"
#include "pixel_keys.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

/// Higher dimensions are random: with practical numbers of samples, bases as large as the hundredth
/// prime are no better.
constexpr uint32_t kBaseCount = 128;

/// A prime, and the weights of digits in it.
struct Base {
  constexpr explicit Base(uint32_t prime) : modulus(prime), factors(prime - 1) {
    // Enough digits for 32 bits, except for base 2, which isn't scrambled digit by digit.
    uint64_t weight = ~uint64_t{0} / prime;
    for (size_t i = 0; i < weights.size(); ++i, weight /= prime) weights[i] = weight;
  }

  Modulus modulus;
  Modulus factors;                     ///< prime - 1
  std::array<uint64_t, 21> weights{};  ///< prime^-1, prime^-2 ..., times 2^64
};

template <size_t... i>
constexpr std::array<Base, kBaseCount> make_bases(std::index_sequence<i...> /*of kBaseCount*/) {
  std::array<uint32_t, kBaseCount> primes{};
  uint32_t count = 0;
  for (uint32_t n = 2; count < kBaseCount; ++n) {
    if (is_prime(n)) primes[count++] = n;
  }
  return {Base(primes[i])...};
}
constexpr std::array<Base, kBaseCount> kBases = make_bases(std::make_index_sequence<kBaseCount>());

/// Returns the Owen-scrambled radical inverse of `index`, times 2^32. Two random words depend on
/// the digits so far, from the lowest on. `bits` chooses the factor of the next linear permutation.
/// `offset` is a fraction whose digits are the images of zeros: the next one, and all after it if
/// the remaining index is 0. The loop therefore ends with the index, and adds the offset.
template <class U>
KINOME_WIDE U scrambled_radical_inverse(U index, const Base& base, const PixelKey<U>& key) {
  using namespace wide::formulas;
  const U prime(base.modulus.number());
  U offset = key.low, bits = key.high;
  U value(0u), weight(~0u);
  for (const uint64_t next_weight : base.weights) {
    const auto is_left = index != U(0u);
    if (none(is_left)) break;
    const Division<U> at = base.modulus.divide(index);
    const U factor = base.factors.random(bits) + U(1u);
    const U digit =
        base.modulus.divide_small(factor * at.remainder + multiply_high(offset, prime)).remainder;
    bits += at.remainder * U(0x9e3779b1u);
    bits = (bits ^ wide::shift_right<15>(bits)) * U(0x735a2d97u);
    const U next_offset = select(at.remainder == U(0u), offset * prime, bits * U(0x915f77f5u));
    const U upper(static_cast<uint32_t>(next_weight >> 32));
    U part = digit * upper;
    if (base.modulus.number() > 16) {  // for smaller digits, the truncated sum is below 2^-25
      const U lower(static_cast<uint32_t>(next_weight) >> 10);  // digits are below 2^10
      part += wide::shift_right<22>(digit * lower);
    }
    value = select(is_left, value + part, value);
    weight = select(is_left, upper, weight);
    offset = select(is_left, next_offset, offset);
    index = at.quotient;
  }
  return value + multiply_high(offset, weight);
}

constexpr uint32_t kScramble = ~0u;

auto keys(uint32_t dimension) {
  return [dimension](const SampleKey& key) {
    return std::array<uint64_t, 1>{hash_key(key, kScramble, dimension)};
  };
}

template <class U>
KINOME_WIDE auto halton_number(U sample, uint32_t dimension, const PixelKey<U>& key) {
  if (dimension >= kBaseCount) return to_unit_float(random_bits(sample, key));
  if (dimension == 0) {
    return to_unit_float(reverse_bits(scramble_reversed(sample, key.low, key.high)));
  }
  return to_unit_float(scrambled_radical_inverse(sample, kBases[dimension], key));
}

class Halton : public CountedSampler<Halton> {
 public:
  using CountedSampler::CountedSampler;

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return halton_number(key.sample, dimension, to_key(keys(dimension)(key)[0]));
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value_1d(key, dimension), value_1d(key, dimension + 1)};
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    for_each_vector<1>(samples, keys(dimension), [&](size_t i, wide::Uint sample, const auto& of) {
      halton_number(sample, dimension, of[0]).store(out + i);
    });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    fill_1d_block(samples, dimension, out.x);
    fill_1d_block(samples, dimension + 1, out.y);
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Halton, kinome::Category::kSampler, "halton",
              "Owen-scrambled Halton points: good for any number of samples.", kinome::kTable);

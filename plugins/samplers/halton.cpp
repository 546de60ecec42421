// Halton points, Owen-scrambled in each pixel: dimension d is the radical inverse of the sample's
// index in the base of the d-th prime b. Every digit is scrambled depending on the digits before it
// (Owen 1995, "Randomly permuted (t,m,s)-nets"); the permutations are random linear ones, a digit +
// c modulo b, which give pairs of points the same distribution and thus the same variance
// (Matoušek 1998). Any prefix is evenly spread; b^k samples stratify a dimension perfectly.
//
//   <sampler type="halton"><integer name="sample_count" value="64"/></sampler>

#include <array>
#include <memory>

#include "kinome/plugin.h"
#include "kinome/owen.h"
#include "sampler_common.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

/// Dimensions beyond these are drawn at random: a base as large as the hundredth prime does no
/// better at any practical number of samples.
constexpr uint32_t kBaseCount = 128;

constexpr std::array<uint32_t, kBaseCount> make_primes() {
  std::array<uint32_t, kBaseCount> primes{};
  uint32_t count = 0;
  for (uint32_t candidate = 2; count < kBaseCount; ++candidate) {
    bool is_prime = true;
    for (uint32_t i = 0; i < count && is_prime; ++i) is_prime = candidate % primes[i] != 0;
    if (is_prime) primes[count++] = candidate;
  }
  return primes;
}
constexpr std::array<uint32_t, kBaseCount> kPrimes = make_primes();

/// `digit` under the random linear permutation of 0 … base - 1 (a prime) that `bits` names.
uint32_t scramble_digit(uint32_t digit, uint32_t base, uint64_t bits) {
  const uint64_t factor = 1 + ((bits >> 32) * (base - 1) >> 32);
  const uint64_t offset = (bits & 0xffffffffu) * base >> 32;
  return static_cast<uint32_t>((factor * digit + offset) % base);
}

/// Radical inverse of `index` in `base`, Owen-scrambled. Goes on past the index's last digit, whose
/// zeros are permuted as well, until digits are too small to matter.
float scrambled_radical_inverse(uint32_t index, uint32_t base, uint64_t key) {
  double value = 0;
  double digit_weight = 1;
  uint64_t prefix = key;
  while (digit_weight > 0x1p-26) {
    const uint32_t digit = index % base;
    index /= base;
    digit_weight /= base;
    value += digit_weight * scramble_digit(digit, base, prefix);
    // The permutation of the next digit depends on all digits so far.
    prefix = scatter(prefix + (digit + 1) * 0xd1342543de82ef95u);
  }
  return std::min(static_cast<float>(value), kOneMinusEpsilon);
}

class Halton : public Sampler {
 public:
  explicit Halton(const Properties& props) {
    sample_count_ = read_sample_count(props);
    seed_ = static_cast<uint64_t>(props.integer("seed"));
  }
  Halton(uint32_t count, uint64_t seed) {
    sample_count_ = count;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    if (dimension >= kBaseCount) {
      return to_unit_float(static_cast<uint32_t>(hash_key(key, key.sample, dimension) >> 32));
    }
    const uint64_t scramble = hash_key(key, kScramble, dimension);
    if (dimension == 0) return to_unit_float(reverse_bits(scramble_reversed(key.sample, scramble)));
    return scrambled_radical_inverse(key.sample, kPrimes[dimension], scramble);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value_1d(key, dimension), value_1d(key, dimension + 1)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Halton>(count, seed_);
  }

 private:
  static constexpr uint32_t kScramble = ~0u;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Halton, kinome::Category::kSampler, "halton",
              "Owen-scrambled Halton points: good at any number of samples.", kinome::kTable);

// Orthogonal array sampling (Jarosz et al. 2019): p² samples, p a prime, that are jittered in p x p
// strata of *any* two dimensions, and in p² strata of each. The array is Bose's of strength 2: digits
// a and b of a sample's number give its stratum a in the first dimension and b + a k in the others.
// It has p + 1 dimensions; those after them have an array of their own.
//
//   <sampler type="orthogonal"><integer name="sample_count" value="49"/></sampler>

#include <memory>

#include "kinome/plugin.h"
#include "strata.h"

namespace kinome {
namespace {

const Parameter kTable[] = {
    KINOME_SAMPLER_PARAMETERS,
    kJitter,
};

bool is_prime(uint32_t n) {
  for (uint32_t i = 2; i * i <= n; ++i) {
    if (n % i == 0) return false;
  }
  return n >= 2;
}
/// The smallest prime whose square is no less.
uint32_t prime_for(uint32_t count) {
  uint32_t p = 2;
  while (p * p < count || !is_prime(p)) ++p;
  return p;
}

class Orthogonal : public Sampler {
 public:
  explicit Orthogonal(const Properties& props)
      : Orthogonal(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                   props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  Orthogonal(uint32_t count, uint64_t seed, bool jitters)
      : prime_(prime_for(count)), jitters_(jitters) {
    sample_count_ = prime_ * prime_;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return value(key, dimension, dimension ^ kOneDimension);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value(key, dimension, dimension ^ kTwoDimensions),
            value(key, dimension + 1, (dimension + 1) ^ kTwoDimensions)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Orthogonal>(count, seed_, jitters_);
  }

 private:
  static constexpr uint32_t kArrays = 0x6f726472;

  /// `salt`: of the dimension's own randomness; numbers of one alone are none of a pair's.
  float value(const SampleKey& key, uint32_t dimension, uint32_t salt) const {
    const uint32_t set = key.sample / sample_count_, array = dimension / (prime_ + 1);
    const uint32_t column = dimension % (prime_ + 1);
    const uint32_t number = permute(key.sample % sample_count_, sample_count_,
                                    hash_key(key, set, array ^ kArrays));
    const uint32_t a = number / prime_, b = number % prime_;
    const uint32_t stratum =
        column == 0
            ? a
            : static_cast<uint32_t>((b + static_cast<uint64_t>(a) * (column - 1)) % prime_);
    // Of the samples of one stratum each takes another of its p parts: they are told apart by b in
    // the first column, and by a in all others.
    const uint32_t part = column == 0 ? b : a;
    const uint64_t hash = hash_key(key, set, salt);
    const uint32_t place = permute(stratum, prime_, hash) * prime_ +
                           permute(part, prime_, scatter(hash + stratum * 2 + 1));
    const float jitter =
        jitters_ ? to_unit_float(static_cast<uint32_t>(scatter(hash + number * 2 + 2) >> 32))
                 : 0.5f;
    return in_stratum(place, jitter, sample_count_);
  }

  uint32_t prime_;
  bool jitters_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Orthogonal, kinome::Category::kSampler, "orthogonal",
              "Orthogonal arrays: stratified in any two dimensions.", kinome::kTable);

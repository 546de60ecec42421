// Orthogonal array sampling (Jarosz et al. 2019): p² samples, where p is prime, are jittered in
// p x p strata of *any* two dimensions, and in p² strata of each dimension. The array is Bose's of
// strength 2: with digits a and b of the sample's number, the stratum is a in the first dimension
// and (b + a k) modulo p in the others. An array has p + 1 dimensions; further dimensions use
// further arrays.
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
    ignored_row("strength", ParameterType::kInteger, "Bose's construction has strength 2"),
};

/// Returns the smallest prime whose square is at least `count`.
uint32_t prime_for(uint32_t count) {
  uint32_t p = 2;
  while (p * p < count || !is_prime(p)) ++p;
  return p;
}

class Orthogonal : public Sampler {
  static constexpr uint32_t kArrays = 0x6f726472;

  uint32_t array_of(uint32_t dimension) const { return dimension / (prime_.number() + 1); }

  /// Returns the keys of a dimension's array and of the dimension itself. Keys of single numbers
  /// differ from those of pairs.
  auto one(uint32_t dimension) const {
    return [dimension, array = array_of(dimension)](const SampleKey& key, uint32_t set) {
      return std::array<uint64_t, 2>{hash_key(key, set, array ^ kArrays),
                                     hash_key(key, set, dimension ^ kOneDimension)};
    };
  }
  auto two(uint32_t dimension) const {
    const uint32_t x = array_of(dimension), y = array_of(dimension + 1);
    return [dimension, x, y](const SampleKey& key, uint32_t set) {
      return std::array<uint64_t, 4>{
          hash_key(key, set, x ^ kArrays), hash_key(key, set, dimension ^ kTwoDimensions),
          hash_key(key, set, y ^ kArrays), hash_key(key, set, (dimension + 1) ^ kTwoDimensions)};
    };
  }

 public:
  explicit Orthogonal(const Properties& props)
      : Orthogonal(read_sample_count(props), static_cast<uint64_t>(props.integer("seed")),
                   props.boolean("jitter")) {
    warn_if_rounded(props, read_sample_count(props), sample_count_);
  }
  Orthogonal(uint32_t count, uint64_t seed, bool jitters)
      : Orthogonal(Modulus(prime_for(count)), seed, jitters) {}
  Orthogonal(const Modulus& prime, uint64_t seed, bool jitters)
      : prime_(prime),
        numbers_(Grid(prime.number(), prime.number())),
        strata_(prime.number(), prime.number()),
        jitter_{jitters},
        sets_(numbers_.grid().count()),
        size_(1 / static_cast<float>(sets_.count())) {
    sample_count_ = sets_.count();
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return sets_.at<2>(key, one(dimension), [&](uint32_t within, const auto& keys) {
      return value(digits(within, keys[0]), dimension, keys[1], jitter_.one(within, keys[1]));
    });
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return sets_.at<4>(key, two(dimension), [&](uint32_t within, const auto& keys) {
      const Pair<uint32_t> pair = values(within, dimension, keys);
      return Vec2(pair.x, pair.y);
    });
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    sets_.for_each_vector<2>(
        samples, one(dimension), [&](size_t i, wide::Uint within, const auto& keys) {
          value(digits(within, keys[0]), dimension, keys[1], jitter_.one(within, keys[1]))
              .store(out + i);
        });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    sets_.for_each_vector<4>(samples, two(dimension),
                             [&](size_t i, wide::Uint within, const auto& keys) {
                               const Pair<wide::Uint> pair = values(within, dimension, keys);
                               pair.x.store(out.x + i);
                               pair.y.store(out.y + i);
                             });
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Orthogonal>(count, seed_, jitter_.is_random);
  }

 private:
  /// Returns the digits b (column) and a (row) of a sample's number in an array. Samples have a
  /// random order.
  template <class U>
  KINOME_WIDE PermutedCell<U> digits(U within, const PixelKey<U>& array) const {
    return numbers_.cell(within, array);
  }
  template <class U>
  KINOME_WIDE Real<U> value(const PermutedCell<U>& digits, uint32_t dimension, const PixelKey<U>& key,
                            Real<U> jitter) const {
    const uint32_t column = dimension % (prime_.number() + 1);
    // The samples of a stratum use different ones of its p parts: in the first dimension, they
    // differ in b; in the others, in a.
    U stratum = digits.row, part = digits.column;
    if (column > 0) {
      stratum = prime_.divide_small(digits.column + digits.row * U(column - 1)).remainder;
      part = digits.row;
    }
    return in_stratum(strata_.part(stratum, part, key.low), jitter, size_);
  }
  template <class U>
  KINOME_WIDE Pair<U> values(U within, uint32_t dimension,
                             const std::array<PixelKey<U>, 4>& keys) const {
    const PermutedCell<U> x = digits(within, keys[0]);
    const bool is_same = array_of(dimension) == array_of(dimension + 1);
    const PermutedCell<U> y = is_same ? x : digits(within, keys[2]);
    const Pair<U> jitter = jitter_.two(within, keys[1]);
    return {value(x, dimension, keys[1], jitter.x), value(y, dimension + 1, keys[3], jitter.y)};
  }

  Modulus prime_;
  CellOrder numbers_;
  LineOrder strata_;
  Jitter jitter_;
  SampleSets sets_;
  float size_;  ///< width of a dimension's p² strata
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Orthogonal, kinome::Category::kSampler, "orthogonal",
              "Orthogonal arrays: stratified in any two dimensions.", kinome::kTable);

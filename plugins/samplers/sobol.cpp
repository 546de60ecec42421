// Owen-scrambled Sobol points. The first two dimensions of Sobol's sequence, a (0, 2)-sequence in
// base 2, are reused for each pair of dimensions with another scramble and order (padding; Kollig
// and Keller 2002). The first 2^k samples of a pixel, and every aligned block of 2^k, are a
// (0, k, 2)-net in each pair and a (0, k, 1)-net in each single dimension.
//
//   <sampler type="sobol"><integer name="sample_count" value="64"/></sampler>
//
// Scrambles and orders are hashes (Burley 2020, "Practical hash-based Owen scrambling"). The order
// of a pair's points is an Owen scramble of the index, which keeps every aligned block of 2^k
// together and makes pairs independent of one another.

#include <memory>

#include "kinome/plugin.h"
#include "pixel_keys.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

/// Rounds up to a power of four, as Mitsuba's ldsampler does.
uint32_t round_to_power_of_four(uint32_t count) {
  uint32_t rounded = 4;
  while (rounded < count) rounded *= 4;
  return rounded;
}

constexpr uint32_t kOneDimension = 1;
constexpr uint32_t kTwoDimensions = 2;
constexpr uint64_t kSaltX = 0x2545f4914f6cdd1du;
constexpr uint64_t kSaltY = 0x9e6c63d0876a9a47u;

/// Return keys that all samples of a pixel share: for their order and for the scramble of each
/// coordinate.
auto keys_of_one(uint32_t dimension) {
  return [dimension](const SampleKey& key) {
    const uint64_t order = hash_key(key, dimension, kOneDimension);
    return std::array<uint64_t, 2>{order, scatter(order + kSaltX)};
  };
}
auto keys_of_two(uint32_t dimension) {
  return [dimension](const SampleKey& key) {
    const uint64_t order = hash_key(key, dimension, kTwoDimensions);
    return std::array<uint64_t, 3>{order, scatter(order + kSaltX), scatter(order + kSaltY)};
  };
}

class Sobol : public CountedSampler<Sobol> {
 public:
  explicit Sobol(const Properties& props) : CountedSampler(props) {
    const uint32_t requested = sample_count_;
    sample_count_ = round_to_power_of_four(requested);
    warn_if_rounded(props, requested, sample_count_);
  }
  using CountedSampler::CountedSampler;

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    const auto [order, x] = keys_of_one(dimension)(key);
    return owen_sobol_first(owen_scramble(key.sample, order), x);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const auto [order, x, y] = keys_of_two(dimension)(key);
    return owen_sobol_point(owen_scramble(key.sample, order), x, y);
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    for_each_vector<2>(samples, keys_of_one(dimension),
                       [&](size_t i, wide::Uint sample, const auto& keys) {
                         first(reorder(sample, keys[0]), keys[1]).store(out + i);
                       });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    for_each_vector<3>(samples, keys_of_two(dimension),
                       [&](size_t i, wide::Uint sample, const auto& keys) {
                         const wide::Uint index = reorder(sample, keys[0]);
                         first(index, keys[1]).store(out.x + i);
                         first(sobol_second_reversed(index), keys[2]).store(out.y + i);
                       });
  }
  /// Rounds to powers of two, which suffice for nets; powers of four are Mitsuba's rule for scenes.
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    uint32_t rounded = 1;
    while (rounded < count && rounded < kMaxSampleCount) rounded *= 2;
    return std::make_shared<Sobol>(rounded, seed_);
  }

 private:
  /// Vector versions of owen_scramble and owen_sobol_first.
  KINOME_WIDE static wide::Uint reorder(wide::Uint sample, const PixelKey<wide::Uint>& key) {
    return reverse_bits(scramble_reversed(reverse_bits(sample), key.low, key.high));
  }
  KINOME_WIDE static wide::Float first(wide::Uint index, const PixelKey<wide::Uint>& key) {
    return to_unit_float(reverse_bits(scramble_reversed(index, key.low, key.high)));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Sobol, kinome::Category::kSampler, "sobol",
              "Owen-scrambled Sobol points: the best choice. Called ldsampler in Mitsuba.",
              kinome::kTable);

// Independent uniform random numbers from a counter-based generator: each number is a hash of seed,
// pixel, sample and dimension.
//
//   <sampler type="independent"><integer name="sample_count" value="64"/></sampler>

#include "kinome/plugin.h"
#include "pixel_keys.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

auto keys(uint32_t dimension) {
  return [dimension](const SampleKey& key) {
    return std::array<uint64_t, 1>{hash_key(key, 0, dimension)};
  };
}

class Independent : public CountedSampler<Independent> {
 public:
  using CountedSampler::CountedSampler;

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return to_unit_float(random_bits(key.sample, to_key(keys(dimension)(key)[0])));
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const auto bits = random_bits_pair(key.sample, to_key(keys(dimension)(key)[0]));
    return {to_unit_float(bits.x), to_unit_float(bits.y)};
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    for_each_vector<1>(samples, keys(dimension), [&](size_t i, wide::Uint sample, const auto& of) {
      to_unit_float(random_bits(sample, of[0])).store(out + i);
    });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    for_each_vector<1>(samples, keys(dimension), [&](size_t i, wide::Uint sample, const auto& of) {
      const auto bits = random_bits_pair(sample, of[0]);
      to_unit_float(bits.x).store(out.x + i);
      to_unit_float(bits.y).store(out.y + i);
    });
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Independent, kinome::Category::kSampler, "independent",
              "Independent uniform random numbers.", kinome::kTable);

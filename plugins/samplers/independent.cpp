// Independent uniform random numbers: a counter-based generator, one hash of pixel, sample and
// dimension a number.
//
//   <sampler type="independent"><integer name="sample_count" value="64"/></sampler>

#include <memory>

#include "kinome/plugin.h"
#include "sampler_common.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

class Independent : public Sampler {
 public:
  explicit Independent(const Properties& props) {
    sample_count_ = read_sample_count(props);
    seed_ = static_cast<uint64_t>(props.integer("seed"));
  }
  Independent(uint32_t count, uint64_t seed) {
    sample_count_ = count;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return to_unit_float(static_cast<uint32_t>(hash_key(key, key.sample, dimension) >> 32));
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return to_unit_square(hash_key(key, key.sample, dimension));
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    for_each_sample(samples, dimension, [&](size_t i, uint64_t hash) {
      out[i] = to_unit_float(static_cast<uint32_t>(hash >> 32));
    });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    for_each_sample(samples, dimension,
                    [&](size_t i, uint64_t hash) { out.set(i, to_unit_square(hash)); });
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Independent>(count, seed_);
  }

 private:
  /// Vectors have no wide product of 64 bits: hashes are made one by one.
  template <class Function>
  static void for_each_sample(const PixelSamples& samples, uint32_t dimension, const Function& fn) {
    size_t i = 0;
    for (size_t p = 0; p < samples.pixels; ++p) {
      const SampleKey key{samples.x[p], samples.y[p], 0, samples.seed};
      for (uint32_t s = 0; s < samples.samples; ++s) {
        fn(i++, hash_key(key, samples.first_sample + s, dimension));
      }
    }
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Independent, kinome::Category::kSampler, "independent",
              "Independent uniform random numbers.", kinome::kTable);

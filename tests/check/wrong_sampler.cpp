// Independent random numbers, except for their fault.

#include "kinome/sampler.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongNumbers final : public Sampler {
 public:
  explicit WrongNumbers(const Properties& props) : wrong_(props) {}

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    const uint64_t which = wrong_.is("same dimensions") ? 0 : dimension;
    const uint64_t x = wrong_.is("same pixels") ? key.x / 2 : key.x;
    const float u = to_unit_float(static_cast<uint32_t>(
        hash_words(key.seed, x << 32 | key.y, key.sample, which)));
    if (wrong_.is("one")) return u > 0.99f ? 1 : u;
    return wrong_.is("uneven") ? u * u : u;
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value_1d(key, dimension), value_1d(key, dimension + 1)};
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    Sampler::fill_1d_block(samples, dimension + wrong_.or_wrong("block", 0u, 1u), out);
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    auto other = std::make_shared<WrongNumbers>(*this, count);
    return other;
  }
  WrongNumbers(const WrongNumbers& other, uint32_t count) : wrong_(other.wrong_) {
    sample_count_ = count;
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongNumbers, kinome::Category::kSampler, "wrong", "Has a fault.",
              kinome::test::kTable);

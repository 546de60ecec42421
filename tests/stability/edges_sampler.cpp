// Random numbers of which half are at the ends of [0, 1) or at simple fractions, to find errors
// there. Estimates with them are biased.
//
//   <sampler type="edges"><integer name="sample_count" value="16"/></sampler>

#include <memory>

#include "kinome/plugin.h"
#include "kinome/sampler.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"sample_count", ParameterType::kInteger, "4", "samples per pixel"},
};

class Edges final : public Sampler {
 public:
  explicit Edges(const Properties& props) {
    sample_count_ = static_cast<uint32_t>(props.integer("sample_count", 1, 1 << 20));
  }
  explicit Edges(uint32_t count) { sample_count_ = count; }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    constexpr float kEnds[] = {0,    0x1p-24f, 0x1p-12f,     0.25f,        0.5f - 0x1p-25f,
                               0.5f, 0.75f,    1 - 0x1p-12f, 1 - 0x1p-23f, kOneMinusEpsilon};
    const uint64_t bits =
        hash_words(key.seed, dimension, key.sample, (uint64_t{key.x} << 32) | key.y);
    if (bits & 1) return to_unit_float(static_cast<uint32_t>(bits >> 32));
    return kEnds[(bits >> 1) % std::size(kEnds)];
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const float x = value_1d(key, dimension);
    return {x, value_1d(key, dimension + 1)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Edges>(count);
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Edges, kinome::Category::kSampler, "edges",
              "Random numbers that are often 0, nearly 1, or simple fractions.", kinome::kTable);

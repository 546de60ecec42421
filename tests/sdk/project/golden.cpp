// Points of the most uniform additive sequence in the plane (Roberts 2018): each step adds the
// powers of 1 / 1.3247…, the plastic number. Pixels and dimensions start at random points.
//
//     <sampler type="golden"> <integer name="sample_count" value="64"/> </sampler>

#include <kinome/plugin.h>
#include <kinome/sampler.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"sample_count", ParameterType::kInteger, "16", "Samples per pixel."},
    {"seed", ParameterType::kInteger, "0", "Seed of the starting points."},
};

/// Pairs of 32-bit numbers, which wrap around.
struct Sequence {
  Sequence(const SampleKey& key, uint64_t which)
      : first(hash_words(uint64_t{key.y} << 32 | key.x, key.seed, which)) {}
  float x(uint32_t i) const {
    return to_unit_float(static_cast<uint32_t>(first >> 32) + i * 0xc13fa9a9u);
  }
  float y(uint32_t i) const {
    return to_unit_float(static_cast<uint32_t>(first) + i * 0x91e10da5u);
  }
  uint64_t first;
};

class Golden final : public Sampler {
 public:
  explicit Golden(const Properties& props)
      : Golden(static_cast<uint32_t>(props.integer("sample_count", 1, 1 << 30)),
               static_cast<uint64_t>(props.integer("seed"))) {}
  Golden(uint32_t count, uint64_t seed) { sample_count_ = count, seed_ = seed; }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return Sequence(key, 2 * dimension).x(key.sample);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    const Sequence pair(key, 2 * dimension + 1);
    return {pair.x(key.sample), pair.y(key.sample)};
  }
  // For a block, hashes are computed once per pixel. The compiler vectorises the rest.
  void fill_2d_block(const PixelSamples& of, uint32_t dimension,
                     const Columns2& out) const override {
    for (size_t p = 0, i = 0; p < of.pixels; ++p, i += of.samples) {
      const Sequence pair({of.x[p], of.y[p], 0, of.seed}, 2 * dimension + 1);
      for (uint32_t s = 0; s < of.samples; ++s) out.x[i + s] = pair.x(of.first_sample + s);
      for (uint32_t s = 0; s < of.samples; ++s) out.y[i + s] = pair.y(of.first_sample + s);
    }
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    return std::make_shared<Golden>(count, seed_);
  }
};

}  // namespace

KINOME_PLUGIN(Golden, Category::kSampler, "golden", "An additive sequence in the plane.",
              kParameters);

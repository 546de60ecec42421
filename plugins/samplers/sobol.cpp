// Owen-scrambled Sobol points: the first two dimensions of Sobol's sequence, a (0, 2)-sequence in
// base 2, used anew for each pair of dimensions (padding; Kollig and Keller 2002) with its own
// scramble and order. The first 2^k samples of a pixel, and every aligned block of 2^k, are a
// (0, k, 2)-net in each pair and a (0, k, 1)-net in each single dimension.
//
//   <sampler type="sobol"><integer name="sample_count" value="64"/></sampler>
//
// Scrambles and orders are hashes (Burley 2020, "Practical hash-based Owen scrambling"). The order
// of a pair's points is scrambled, too, as a number: that keeps every aligned block of 2^k together
// and makes pairs independent of one another.

#include <memory>

#include "kinome/plugin.h"
#include "kinome/owen.h"
#include "kinome/wide/random.h"
#include "pixel_keys.h"
#include "sampler_common.h"

namespace kinome {
namespace {

const Parameter kTable[] = {KINOME_SAMPLER_PARAMETERS};

/// Rounds up to a power of four, as Mitsuba's ldsampler does.
uint32_t round_to_power_of_four(uint32_t count) {
  uint32_t rounded = 4;
  while (rounded < count) rounded *= 4;
  return rounded;
}

class Sobol : public Sampler {
 public:
  explicit Sobol(const Properties& props) {
    const uint32_t wanted = read_sample_count(props);
    sample_count_ = round_to_power_of_four(wanted);
    warn_if_rounded(props, wanted, sample_count_);
    seed_ = static_cast<uint64_t>(props.integer("seed"));
  }
  Sobol(uint32_t count, uint64_t seed) {
    sample_count_ = count;
    seed_ = seed;
  }

  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    const uint64_t hash = hash_key(key, dimension, kOneDimension);
    return owen_sobol_first(owen_scramble(key.sample, hash), scatter(hash + kSaltX));
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return Pair(key, dimension).at(key.sample);
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    thread_local PixelKeys order, x;
    order.resize(samples.pixels), x.resize(samples.pixels);
    for (size_t p = 0; p < samples.pixels; ++p) {
      const uint64_t hash =
          hash_key({samples.x[p], samples.y[p], 0, samples.seed}, dimension, kOneDimension);
      order.set(p, hash);
      x.set(p, scatter(hash + kSaltX));
    }
    for_each_vector(samples, [&](size_t i, wide::Uint sample, const auto& of_pixel) {
      first(reorder(sample, order, of_pixel), x, of_pixel).store(out + i);
    });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    thread_local PixelKeys order, x, y;
    order.resize(samples.pixels), x.resize(samples.pixels), y.resize(samples.pixels);
    for (size_t p = 0; p < samples.pixels; ++p) {
      const Pair pair({samples.x[p], samples.y[p], 0, samples.seed}, dimension);
      order.set(p, pair.order);
      x.set(p, pair.x);
      y.set(p, pair.y);
    }
    for_each_vector(samples, [&](size_t i, wide::Uint sample, const auto& of_pixel) {
      const wide::Uint index = reorder(sample, order, of_pixel);
      first(index, x, of_pixel).store(out.x + i);
      first(sobol_second_reversed(index), y, of_pixel).store(out.y + i);
    });
  }
  /// Only powers of two are needed for nets; those of four are Mitsuba's rule for scenes.
  std::shared_ptr<Sampler> with_sample_count(uint32_t count) const override {
    uint32_t rounded = 1;
    while (rounded < count && rounded < kMaxSampleCount) rounded *= 2;
    return std::make_shared<Sobol>(rounded, seed_);
  }

 private:
  static constexpr uint32_t kOneDimension = 1;
  static constexpr uint32_t kTwoDimensions = 2;
  static constexpr uint64_t kSaltX = 0x2545f4914f6cdd1du;
  static constexpr uint64_t kSaltY = 0x9e6c63d0876a9a47u;

  /// A pair of dimensions in one pixel: what all its samples share.
  struct Pair {
    Pair(const SampleKey& key, uint32_t dimension)
        : order(hash_key(key, dimension, kTwoDimensions)),
          x(scatter(order + kSaltX)),
          y(scatter(order + kSaltY)) {}
    Vec2 at(uint32_t sample) const {
      const uint32_t index = owen_scramble(sample, order);
      return owen_sobol_point(index, x, y);
    }
    uint64_t order;
    uint64_t x;
    uint64_t y;
  };

  /// owen_scramble and owen_sobol_first of a vector of samples.
  template <class OfPixel>
  static wide::Uint reorder(wide::Uint sample, const PixelKeys& key, const OfPixel& of_pixel) {
    return reverse_bits(
        scramble_reversed(reverse_bits(sample), of_pixel(key.low()), of_pixel(key.high())));
  }
  template <class OfPixel>
  static wide::Float first(wide::Uint index, const PixelKeys& key, const OfPixel& of_pixel) {
    return to_unit_float(
        reverse_bits(scramble_reversed(index, of_pixel(key.low()), of_pixel(key.high()))));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Sobol, kinome::Category::kSampler, "sobol",
              "Owen-scrambled Sobol points: the best choice. Mitsuba's name for it is ldsampler.",
              kinome::kTable);

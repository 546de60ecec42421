#pragma once

#include <cstdint>
#include <memory>

#include "kinome/blocks.h"
#include "kinome/math.h"
#include "kinome/object.h"

namespace kinome {

/// Identifies one random number: the complete input of a sampler besides the dimension.
struct SampleKey {
  uint32_t x = 0;  ///< pixel of the full film
  uint32_t y = 0;
  uint32_t sample = 0;  ///< index in the pixel; any uint32_t, even beyond sample_count()
  uint64_t seed = 0;    ///< seed of the render: combines --seed and the sampler's `seed`
};

/// Random or low-discrepancy numbers as a pure function of (key, dimension), in any order and on
/// any thread. For a fixed pixel and dimension (or pair of dimensions), samples 0 … sample_count()
/// - 1 are stratified. Different pixels, dimensions and seeds are randomised independently. All
/// values are in [0, 1).
class KINOME_EXPORT Sampler : public Object {
 public:
  /// Samples per pixel, rounded up to a number that the sampler supports.
  uint32_t sample_count() const { return sample_count_; }
  /// Parameter `seed` of the sampler.
  uint64_t seed() const { return seed_; }

  /// Value of one dimension.
  virtual float value_1d(const SampleKey& key, uint32_t dimension) const = 0;
  /// Pair of values at `dimension` and `dimension` + 1, stratified jointly.
  virtual Vec2 value_2d(const SampleKey& key, uint32_t dimension) const = 0;
  /// Block versions of value_1d() and value_2d(). Default: one by one.
  virtual void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const;
  virtual void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                             const Columns2& out) const;
  /// Returns a sampler of the same type with another sample count. For example, `clustered` takes
  /// 128 shadow rays per camera ray, stratified as one set.
  virtual std::shared_ptr<Sampler> with_sample_count(uint32_t count) const = 0;

 protected:
  uint32_t sample_count_ = 4;
  uint64_t seed_ = 0;
};

/// Mixes the bits of a 64-bit number, bijectively; not cryptographic.
inline uint64_t mix_bits(uint64_t v) {
  v ^= v >> 31;
  v *= 0x7fb5d329728ea185u;
  v ^= v >> 27;
  v *= 0x81dadef4bc2dd44du;
  v ^= v >> 33;
  return v;
}
/// Hashes up to four 64-bit numbers, for seeds and scrambles; not cryptographic.
inline uint64_t hash_words(uint64_t a, uint64_t b = 0, uint64_t c = 0, uint64_t d = 0) {
  uint64_t h = mix_bits(a + 0x9e3779b97f4a7c15u);
  h = mix_bits(h ^ (b + 0xbf58476d1ce4e5b9u));
  h = mix_bits(h ^ (c + 0x94d049bb133111ebu));
  return mix_bits(h ^ (d + 0xd6e8feb86659fd93u));
}
/// Converts the upper 24 bits to a float in [0, 1); never rounds up to 1.
inline float to_unit_float(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

}  // namespace kinome

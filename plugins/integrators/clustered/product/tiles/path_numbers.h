#pragma once

#include <memory>

#include "kinome/wide/owen.h"
#include "kinome/sampler.h"
#include "kinome/wide/random.h"
#include "kinome/wide/vectors.h"

namespace kinome {

/// Independent random numbers for paths that can't be stratified together. Each path is its own
/// "pixel": x and y are the halves of a well-mixed seed. Stateless.
class PathNumbers final : public Sampler {
 public:
  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return to_unit_float(bits_of(key.x, key.y, dimension));
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value_1d(key, dimension), value_1d(key, dimension + 1)};
  }
  void fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const override {
    wide::for_lanes(samples.pixels, [&](size_t i) {
      const wide::Uint bits =
          bits_of(wide::Uint::load(samples.x + i), wide::Uint::load(samples.y + i), dimension);
      to_unit_float(bits).store(out + i);
    });
  }
  void fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                     const Columns2& out) const override {
    fill_1d_block(samples, dimension, out.x);
    fill_1d_block(samples, dimension + 1, out.y);
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t) const override {
    return std::make_shared<PathNumbers>();
  }

 private:
  template <class U>
  static U bits_of(U x, U y, uint32_t dimension) {
    return mix_32(x + mix_32(y + U(0x9e3779b9u * (dimension + 1))));
  }
};

}  // namespace kinome

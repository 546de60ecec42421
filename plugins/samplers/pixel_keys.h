#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kinome/blocks.h"
#include "lane_integers.h"
#include "sampler_common.h"

namespace kinome {

/// 64 random bits.
template <class U>
struct PixelKey {
  U low, high;
};
inline PixelKey<uint32_t> to_key(uint64_t bits) {
  return {static_cast<uint32_t>(bits), static_cast<uint32_t>(bits >> 32)};
}

/// Returns 32 random bits, or a pair of them, for an `index` under a key.
template <class U>
KINOME_WIDE U random_bits(U index, PixelKey<U> key) {
  return mix_32(mix_32(index + key.low) + key.high);
}
template <class U>
struct BitsPair {
  U x, y;
};
template <class U>
KINOME_WIDE BitsPair<U> random_bits_pair(U index, PixelKey<U> key) {
  const U bits = mix_32(index + key.low);
  // The two sums differ by an amount that depends on the key and is never 0.
  return {mix_32(bits + key.high), mix_32(bits + (key.high ^ U(0x5bd1e995u)))};
}

/// n keys for each pixel of a column.
template <size_t n>
class KeyColumns {
 public:
  void resize(size_t count) {
    const size_t size = count + kBlockLanes;  // a vector may begin at any pixel
    if (columns_[0].size() >= size) return;
    for (std::vector<uint32_t>& column : columns_) column.resize(size);
  }
  void set(size_t i, const std::array<uint64_t, n>& keys) {
    for (size_t k = 0; k < n; ++k) {
      const PixelKey<uint32_t> key = to_key(keys[k]);
      columns_[2 * k][i] = key.low;
      columns_[2 * k + 1][i] = key.high;
    }
  }
  /// Returns a vector of keys. read(const uint32_t*) must load one vector from a column.
  template <class Read>
  KINOME_WIDE std::array<PixelKey<wide::Uint>, n> keys(const Read& read) const {
    std::array<PixelKey<wide::Uint>, n> keys;
    for (size_t k = 0; k < n; ++k) {
      keys[k] = {read(columns_[2 * k].data()), read(columns_[2 * k + 1].data())};
    }
    return keys;
  }

 private:
  std::array<std::vector<uint32_t>, 2 * n> columns_;
};

/// Calls fn(i, sample, read) for each vector of a block's samples. i is the block index of the
/// first sample, and `sample` has the indices within their pixels (wide::Uint). read(column) loads
/// their pixels' values from a column over pixels, which must be padded by kBlockLanes.
template <class Function>
KINOME_WIDE void for_each_vector(const PixelSamples& samples, const Function& fn) {
  using wide::Uint, wide::kLanes;
  const Uint lane = as_uint(wide::iota());
  const uint32_t per_pixel = samples.samples;
  const size_t count = samples.count();
  if (per_pixel % kLanes == 0) {  // each vector is within a pixel
    size_t i = 0;
    for (size_t p = 0; p < samples.pixels; ++p) {
      const auto read = [&](const uint32_t* column) { return Uint(column[p]); };
      for (uint32_t s = 0; s < per_pixel; s += kLanes, i += kLanes) {
        fn(i, lane + Uint(samples.first_sample + s), read);
      }
    }
  } else if (per_pixel > kLanes) {  // each vector is within one or two pixels
    size_t p = 0;
    uint32_t s = 0;
    for (size_t i = 0; i < count; i += kLanes) {
      const Uint index = lane + Uint(s);
      const wide::Mask is_next = index >= Uint(per_pixel);
      fn(i, select(is_next, index - Uint(per_pixel), index) + Uint(samples.first_sample),
         [&](const uint32_t* column) {
           return select(is_next, Uint(column[p + 1]), Uint(column[p]));
         });
      s += kLanes;
      if (s >= per_pixel) s -= per_pixel, ++p;
    }
  } else {  // each vector is in several pixels
    const Modulus samples_of_pixel(per_pixel);
    size_t p = 0;
    uint32_t s = 0;
    for (size_t i = 0; i < count; i += kLanes) {
      const Division<Uint> at = samples_of_pixel.divide(lane + Uint(s));
      fn(i, at.remainder + Uint(samples.first_sample), [&](const uint32_t* column) {
        const Uint values = Uint::load(column + p);
        return as_uint(pick(as_float(values), as_int(at.quotient)));
      });
      s += kLanes;
      p += s / per_pixel;
      s %= per_pixel;
    }
  }
}

/// Calls fn(i, sample, keys) for each vector of a block's samples. keys_of(key) must return the n
/// keys of a pixel, given its SampleKey with `sample` 0.
template <size_t n, class KeysOf, class Function>
KINOME_WIDE void for_each_vector(const PixelSamples& samples, const KeysOf& keys_of,
                                 const Function& fn) {
  thread_local KeyColumns<n> columns;
  columns.resize(samples.pixels);
  for (size_t p = 0; p < samples.pixels; ++p) {
    columns.set(p, keys_of(SampleKey{samples.x[p], samples.y[p], 0, samples.seed}));
  }
  for_each_vector(samples, [&](size_t i, wide::Uint sample, const auto& read) {
    fn(i, sample, columns.keys(read));
  });
}

}  // namespace kinome

#pragma once

#include <array>
#include <cstdint>

#include "pixel_keys.h"

namespace kinome {

/// Divides a pixel's infinite sequence of samples into sets of `count` samples. Each set has its
/// own keys.
class SampleSets {
 public:
  explicit SampleSets(uint32_t count) : count_(count) {}

  uint32_t count() const { return count_; }

  /// Returns fn(within, keys) for one sample. `within` is its index in its set, and `keys` are from
  /// keys_of(key, set), a std::array<uint64_t, n>.
  template <size_t n, class KeysOf, class Function>
  auto at(const SampleKey& key, const KeysOf& keys_of, const Function& fn) const {
    const std::array<uint64_t, n> bits = keys_of(key, key.sample / count_);
    std::array<PixelKey<uint32_t>, n> keys;
    for (size_t k = 0; k < n; ++k) keys[k] = to_key(bits[k]);
    return fn(key.sample % count_, keys);
  }

  /// Calls fn(i, within, keys) for each vector of a block's samples; i is the block index of the
  /// first sample.
  template <size_t n, class KeysOf, class Function>
  KINOME_WIDE void for_each_vector(PixelSamples samples, const KeysOf& keys_of,
                                   const Function& fn) const {
    const uint32_t first_set = samples.first_sample / count_;
    samples.first_sample %= count_;
    if (samples.first_sample + samples.samples <= count_) {
      const auto of_pixel = [&](const SampleKey& key) { return keys_of(key, first_set); };
      kinome::for_each_vector<n>(samples, of_pixel, fn);
    } else {
      for_each_vector_of_sets<n>(samples, first_set, keys_of, fn);
    }
  }

 private:
  /// Handles pixels whose samples are in several sets. `samples.first_sample` is relative to
  /// `first_set`.
  template <size_t n, class KeysOf, class Function>
  void for_each_vector_of_sets(const PixelSamples& samples, uint32_t first_set,
                               const KeysOf& keys_of, const Function& fn) const {
    using wide::kLanes;
    const uint32_t sets = (samples.first_sample + samples.samples - 1) / count_ + 1;
    thread_local KeyColumns<n> columns;
    columns.resize(samples.pixels * sets);
    for (size_t p = 0; p < samples.pixels; ++p) {
      const SampleKey key{samples.x[p], samples.y[p], 0, samples.seed};
      for (uint32_t s = 0; s < sets; ++s) columns.set(p * sets + s, keys_of(key, first_set + s));
    }
    const size_t count = samples.count();
    uint32_t set = 0, sample = 0, within = samples.first_sample;
    for (size_t i = 0; i < count; i += kLanes) {
      uint32_t set_of[kLanes], within_of[kLanes];
      for (size_t l = 0; l < kLanes; ++l) {
        set_of[l] = set;
        within_of[l] = within;
        if (i + l + 1 >= count) continue;
        if (++within == count_) within = 0, ++set;
        if (++sample < samples.samples) continue;
        if (within > 0) ++set;
        sample = 0, within = samples.first_sample;
      }
      const wide::Int at = wide::Int::load(set_of);
      fn(i, wide::Uint::load(within_of),
         columns.keys([&](const uint32_t* column) { return gather(column, at); }));
    }
  }

  uint32_t count_;
};

}  // namespace kinome

#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/owen.h"
#include "kinome/wide/lanes.h"

namespace kinome {

/// 64 random bits for each pixel of a block, as two columns.
class PixelKeys {
 public:
  void resize(size_t pixels) {
    const size_t size = pixels + kBlockLanes;  // a vector may begin at any pixel
    if (low_.size() < size) low_.resize(size), high_.resize(size);
  }
  void set(size_t pixel, uint64_t key) {
    low_[pixel] = static_cast<uint32_t>(key);
    high_[pixel] = static_cast<uint32_t>(key >> 32);
  }
  const uint32_t* low() const { return low_.data(); }
  const uint32_t* high() const { return high_.data(); }

 private:
  std::vector<uint32_t> low_, high_;
};

/// Calls fn(i, sample, of_pixel) for each vector of a block's samples: i the first one's number in
/// the block, `sample` their indices within their pixels (wide::Uint), and of_pixel(column) what a
/// column over pixels holds for theirs.
template <class Function>
void for_each_vector(const PixelSamples& samples, const Function& fn) {
  using wide::Int, wide::Uint, wide::kLanes;
  if (samples.samples % kLanes == 0) {  // a vector is of one pixel
    size_t i = 0;
    for (size_t p = 0; p < samples.pixels; ++p) {
      const auto of_pixel = [&](const uint32_t* column) { return Uint(column[p]); };
      for (uint32_t s = 0; s < samples.samples; s += kLanes, i += kLanes) {
        fn(i, as_uint(wide::iota()) + Uint(samples.first_sample + s), of_pixel);
      }
    }
    return;
  }
  const size_t count = samples.count();
  if (kLanes % samples.samples == 0) {  // of a few pixels, one after another
    uint32_t pixels[kLanes], indices[kLanes];
    for (uint32_t l = 0; l < kLanes; ++l) {
      pixels[l] = l / samples.samples;
      indices[l] = samples.first_sample + l % samples.samples;
    }
    const Int at = Int::load(pixels);
    const Uint sample = Uint::load(indices);
    for (size_t i = 0, p = 0; i < count; i += kLanes, p += kLanes / samples.samples) {
      fn(i, sample, [&](const uint32_t* column) {
        const Uint keys = Uint::load(column + p);
        return as_uint(pick(as_float(keys), at));
      });
    }
    return;
  }
  uint32_t pixel = 0, sample = 0;
  for (size_t i = 0; i < count; i += kLanes) {
    uint32_t pixels[kLanes], indices[kLanes];
    for (size_t l = 0; l < kLanes; ++l) {
      pixels[l] = pixel;
      indices[l] = samples.first_sample + sample;
      if (i + l + 1 < count && ++sample == samples.samples) ++pixel, sample = 0;
    }
    const Int at = Int::load(pixels);
    fn(i, Uint::load(indices), [&](const uint32_t* column) { return gather(column, at); });
  }
}

/// As owen.h has it, by looking up halves of bytes: a third of the instructions.
KINOME_WIDE wide::Uint reverse_bits(wide::Uint v) {
#if HWY_TARGET == HWY_SCALAR
  return kinome::reverse_bits(wide::hn::GetLane(v.v));
#elif HWY_TARGET == HWY_EMU128
  return reverse_bits<wide::Uint>(v);
#else
  namespace hn = wide::hn;
  using ByteTag = hn::Repartition<uint8_t, wide::UintTag>;
  constexpr ByteTag bytes;
  alignas(16) static constexpr uint8_t kReversed[16] = {0, 8, 4, 12, 2, 10, 6, 14,
                                                        1, 9, 5, 13, 3, 11, 7, 15};
  alignas(16) static constexpr uint8_t kBackward[16] = {3,  2,  1, 0, 7,  6,  5,  4,
                                                        11, 10, 9, 8, 15, 14, 13, 12};
  const auto reversed = hn::LoadDup128(bytes, kReversed);
  const auto half = hn::Set(bytes, uint8_t{15});
  const auto low = hn::And(hn::BitCast(bytes, v.v), half);
  const auto high = hn::And(hn::BitCast(bytes, hn::ShiftRight<4>(v.v)), half);
  // A lookup's shift by 4 stays within its byte.
  const auto of_low = hn::BitCast(
      bytes, hn::ShiftLeft<4>(hn::BitCast(wide::UintTag(), hn::TableLookupBytes(reversed, low))));
  const auto both = hn::Or(of_low, hn::TableLookupBytes(reversed, high));
  const auto backward = hn::LoadDup128(bytes, kBackward);
  return wide::Uint(hn::BitCast(wide::UintTag(), hn::TableLookupBytes(both, backward)));
#endif
}

}  // namespace kinome

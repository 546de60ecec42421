#include "transport/camera/channel_sums.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/rows.h"
#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Maximum number of samples whose values are transposed at once. They fit the cache of first
/// level.
constexpr size_t kMaxTransposed = 128;
/// Number of values that are transposed at once, a vector or more.
constexpr size_t kRowValues = std::max<size_t>(kLanes, 4);
/// Number of rows and columns of the footprint that are summed at once, in registers.
constexpr size_t kRowsAtOnce = kLanes == 16 ? 4 : 2, kPixelsAtOnce = 4;
/// Maximum number of sums before they are added to the film; more for wide filters.
constexpr size_t kMaxSums = 16384;

Rect union_of(const Rect& a, const Rect& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// Adds samples to kRows x kColumns pixels of the footprint. `sums` is the first of them.
template <size_t kRows, size_t kColumns>
void add_to_pixels(const uint32_t* samples, size_t count, const float* rows,
                   const float* const* weights_x, const float* const* weights_y, size_t begin,
                   float* sums, size_t stride, size_t pitch) {
  const float *wx[kColumns], *wy[kRows];
  for (size_t k = 0; k < kColumns; ++k) wx[k] = weights_x[k] + begin;
  for (size_t j = 0; j < kRows; ++j) wy[j] = weights_y[j] + begin;
  Float total[kRows][kColumns];
  for (auto& row : total) std::fill_n(row, kColumns, Float(0.f));
  for (size_t n = 0; n < count; ++n) {
    const size_t i = samples[n];
    const Float values = Float::load(rows + i * kRowValues);
    Float along_x[kColumns];
    for (size_t k = 0; k < kColumns; ++k) along_x[k] = Float(wx[k][i]);
    for (size_t j = 0; j < kRows; ++j) {
      const Float weighted = values * Float(wy[j][i]);
      for (size_t k = 0; k < kColumns; ++k) {
        total[j][k] = mul_add(along_x[k], weighted, total[j][k]);
      }
    }
  }
  for (size_t j = 0; j < kRows; ++j) {
    for (size_t k = 0; k < kColumns; ++k) {
      float* const to = sums + (j * pitch + k) * stride;
      (Float::load(to) + total[j][k]).store(to);
    }
  }
}

}  // namespace

ChannelSums::ChannelSums(const ReconstructionFilter& filter, int reach, size_t values)
    : reach_(reach),
      side_(static_cast<size_t>(2 * reach + 1)),
      values_(values),
      stride_((values + kRowValues) / kRowValues * kRowValues),
      max_pixels_(std::max(side_ * side_, kMaxSums / stride_)),
      arena_(kMaxTransposed * kRowValues),
      rows_(arena_.floats()),
      zeros_(arena_.floats()),
      sums_arena_(max_pixels_ * stride_),
      sums_(sums_arena_.floats()) {
  // Samples in the left half of their pixel have weight 0 in the rightmost pixels, and so on. If
  // this leaves out pixels, each quarter of the pixel is a part.
  const auto inner = static_cast<size_t>(std::max(std::ceil(filter.radius()) - 1, 0.f));
  const auto second = static_cast<size_t>(reach) - inner;
  width_ = side_ - second;
  for (size_t i = 0; i < (second > 0 ? 4u : 1u); ++i) {
    parts_.push_back({i % 2 * second, i / 2 * second, 0, arena_.indices()});
  }
}

/// Lists the samples of each part, counted from `begin`.
void ChannelSums::find_parts(const PixelSamples& samples, size_t p, size_t begin, size_t count,
                             const Columns2& position, const float* kept) {
  const Float x = static_cast<float>(static_cast<int32_t>(samples.x[p]));
  const Float y = static_cast<float>(static_cast<int32_t>(samples.y[p]));
  for (Part& part : parts_) part.count = 0;
  for (size_t s = 0; s < count; s += kLanes) {
    const Uint index = as_uint(iota() + Int(static_cast<int32_t>(s)));
    const Mask valid =
        first_lanes(std::min(count - s, kLanes)) & (Float::load(kept + begin + s) > 0.f);
    const Mask right = Float::load(position.x + begin + s) - x >= 0.5f;
    const Mask below = Float::load(position.y + begin + s) - y >= 0.5f;
    for (Part& part : parts_) {
      Mask inside = valid;
      if (parts_.size() > 1) {
        inside &= part.x > 0 ? right : !right;
        inside &= part.y > 0 ? below : !below;
      }
      part.count += store_selected(inside, index, part.samples + part.count);
    }
  }
}

/// Sets rows_ to the values first_value … of samples begin …; the value after the last is 1.
void ChannelSums::transpose(const std::vector<float*>& columns, const float* kept, size_t begin,
                            size_t count, size_t first_value) {
  const auto column = [&](size_t value) {
    if (value > values_) return static_cast<const float*>(zeros_);
    return (value < values_ ? columns[value] : kept) + begin;
  };
  for (size_t v = 0; v < kRowValues; v += 4) {
    const float* from[4];
    for (size_t k = 0; k < 4; ++k) from[k] = column(first_value + v + k);
    for (size_t s = 0; s < count; s += kLanes) {
      store_rows(Float::load(from[0] + s), Float::load(from[1] + s), Float::load(from[2] + s),
                 Float::load(from[3] + s), rows_ + s * kRowValues + v, kRowValues);
    }
  }
}

template <size_t kRows>
void ChannelSums::add_rows(const Part& part, size_t y, size_t begin, const FilterWeights& weights,
                           float* sums) const {
  const auto pitch = static_cast<size_t>(reached_.width());
  for (size_t x = 0; x < width_; x += kPixelsAtOnce) {
    const auto add = [&](const auto& add_some) {
      for (size_t lane = 0; lane < kRowValues; lane += kLanes) {
        add_some(part.samples, part.count, rows_ + lane, &weights.x[part.x + x],
                 &weights.y[part.y + y], begin,
                 sums + ((part.y + y) * pitch + part.x + x) * stride_ + lane, stride_, pitch);
      }
    };
    switch (width_ - x) {
      case 1: add(add_to_pixels<kRows, 1>); break;
      case 2: add(add_to_pixels<kRows, 2>); break;
      case 3: add(add_to_pixels<kRows, 3>); break;
      default: add(add_to_pixels<kRows, kPixelsAtOnce>);
    }
  }
}

void ChannelSums::add_part(const Part& part, size_t begin, const FilterWeights& weights,
                           float* sums) const {
  size_t y = 0;
  for (; y + kRowsAtOnce <= width_; y += kRowsAtOnce) {
    add_rows<kRowsAtOnce>(part, y, begin, weights, sums);
  }
  for (; y < width_; ++y) add_rows<1>(part, y, begin, weights, sums);
}

/// Adds the samples of pixel `p` of the block to sums_.
void ChannelSums::add_pixel(const PixelSamples& samples, size_t p, const Columns2& position,
                            const std::vector<float*>& columns, const FilterWeights& weights) {
  const int x = static_cast<int32_t>(samples.x[p]) - reach_ - reached_.x0;
  const int y = static_cast<int32_t>(samples.y[p]) - reach_ - reached_.y0;
  float* const sums = sums_ + static_cast<size_t>(y * reached_.width() + x) * stride_;
  const size_t end = (p + 1) * samples.samples;
  for (size_t begin = p * samples.samples; begin < end; begin += kMaxTransposed) {
    const size_t count = std::min(kMaxTransposed, end - begin);
    find_parts(samples, p, begin, count, position, weights.kept);
    for (size_t v = 0; v <= values_; v += kRowValues) {
      transpose(columns, weights.kept, begin, count, v);
      for (const Part& part : parts_) add_part(part, begin, weights, sums + v);
    }
  }
}

void ChannelSums::add_to_film(float weight, FilmTile& film) const {
  float* sums = sums_;
  for (int y = reached_.y0; y < reached_.y1; ++y) {
    for (int x = reached_.x0; x < reached_.x1; ++x, sums += stride_) {
      for (size_t i = 0; weight != 1 && i <= values_; ++i) sums[i] *= weight;
      film.add_sums(x, y, {sums, values_}, sums[values_]);
    }
  }
}

void ChannelSums::add(const PixelSamples& samples, const Columns2& position,
                      const std::vector<float*>& columns, const FilterWeights& weights,
                      float weight, FilmTile& film) {
  const auto reached_by = [&](size_t p) {
    const auto x = static_cast<int32_t>(samples.x[p]), y = static_cast<int32_t>(samples.y[p]);
    return Rect{x - reach_, y - reach_, x + reach_ + 1, y + reach_ + 1};
  };
  for (size_t p = 0; p < samples.pixels;) {
    reached_ = reached_by(p);
    size_t end = p + 1;
    for (; end < samples.pixels; ++end) {
      const Rect larger = union_of(reached_, reached_by(end));
      const auto width = static_cast<size_t>(larger.width());
      if (width * static_cast<size_t>(larger.height()) > max_pixels_) break;
      reached_ = larger;
    }
    std::fill_n(sums_, static_cast<size_t>(reached_.area()) * stride_, 0.f);
    for (; p < end; ++p) add_pixel(samples, p, position, columns, weights);
    add_to_film(weight, film);
  }
}

}  // namespace kinome::transport

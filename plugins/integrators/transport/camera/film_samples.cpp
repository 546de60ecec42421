// Vectorized sums of each pixel's samples.

#include "transport/camera/film_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kinome/wide/rows.h"
#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Sums of a pixel's samples have single precision until they are added to the film's. Values above
/// this one might overflow such a sum, and are added to the film one by one.
constexpr float kMaxSummedValue = 1e30f;
/// Number of values of a sample that are summed at once, and of sums that are stored at once.
constexpr size_t kColumnsAtOnce = 4;

/// Weights of a pixel's samples for another pixel.
struct PixelWeights {
  const float *x, *y, *kept;
  float factor;
};

/// Stores the weighted sums of kColumns columns of samples first … end - 1. If kColumns <
/// kColumnsAtOnce, the sum of weights follows.
template <size_t kColumns>
void sum_columns(const PixelWeights& weights, size_t first, size_t end, float* const* columns,
                 float* to) {
  Float sums[kColumnsAtOnce] = {0.f, 0.f, 0.f, 0.f};
  for (size_t i = first; i < end; i += kLanes) {
    const Mask kept =
        first_lanes(std::min(end - i, kLanes)) & (Float::load(weights.kept + i) > 0.f);
    const Float w =
        select(kept, weights.factor * Float::load(weights.x + i) * Float::load(weights.y + i));
    for (size_t c = 0; c < kColumns; ++c) {
      sums[c] = mul_add(w, Float::load(columns[c] + i), sums[c]);
    }
    if (kColumns < kColumnsAtOnce) sums[kColumns % kColumnsAtOnce] += w;
  }
  store_sums(sums, to);
}

}  // namespace

bool weighs_positions(const ReconstructionFilter& filter) {
  constexpr float kNearEdge = 0.4999f;
  return filter.radius() > 0.5f || filter.eval(0) != filter.eval(kNearEdge);
}

FilmSamples::FilmSamples(const ReconstructionFilter& filter, int values, size_t samples, bool exact)
    : filter_(filter),
      exact_(exact),
      // For a sample anywhere in its pixel: see FilmTile::add.
      reach_(-static_cast<int>(std::floor(0.5f - filter.radius()))),
      arena_(samples + kBlockLanes),
      offset_(arena_.floats()),
      weights_{{}, {}, arena_.floats()},
      // The weight follows the values.
      sums_(static_cast<size_t>(values) / kColumnsAtOnce * kColumnsAtOnce + kColumnsAtOnce) {
  for (int k = -reach_; k <= reach_; ++k) {
    weights_.x.push_back(arena_.floats());
    weights_.y.push_back(arena_.floats());
  }
  const auto count = static_cast<size_t>(values);
  if (!exact && reach_ > 0 && count > kColumnsAtOnce) many_.emplace(filter, reach_, count);
}

/// Sets the weights of all samples along one axis, for pixels -reach_ … reach_ from their own.
void FilmSamples::find_weights(const PixelSamples& samples, const uint32_t* first,
                               const float* position, const std::vector<float*>& weights) {
  const size_t count = samples.count();
  for (int k = -reach_; k <= reach_; ++k) {
    for (size_t p = 0, i = 0; p < samples.pixels; ++p, i += samples.samples) {
      const Float low = static_cast<float>(static_cast<int32_t>(first[p]));
      const Float centre = static_cast<float>(k) + 0.5f;
      for (size_t s = 0; s < samples.samples; s += kLanes) {
        (centre - (Float::load(position + i + s) - low)).store(offset_ + i + s);
      }
    }
    filter_.eval_block(offset_, count, weights[static_cast<size_t>(k + reach_)]);
  }
}

/// Sets samples that aren't finite to 0, with weight 0. Returns false if values are so large that
/// sums may overflow.
bool FilmSamples::drop_non_finite(size_t count, const std::vector<float*>& columns,
                                  FilmTile& film) {
  size_t dropped = 0;
  bool small = true;
  const Int no_sign = std::numeric_limits<int32_t>::max();
  const Int max_summed = std::bit_cast<int32_t>(kMaxSummedValue);
  // Values beyond the samples become 0, too, because a pixel's last vector may reach there.
  for_lanes(count + kBlockLanes, [&](size_t i) {
    const Mask inside = first_lanes(std::min(count - std::min(i, count), kLanes));
    // The bits of numbers without sign are ordered as the numbers; infinity and NaN are greater.
    Int largest_bits = 0;
    for (const float* column : columns) {
      largest_bits = max(largest_bits, as_int(Float::load(column + i)) & no_sign);
    }
    if (all(inside & (largest_bits <= max_summed))) {
      Float(1.f).store(weights_.kept + i);
      return;
    }
    Float largest = 0.f;
    Mask finite = true;
    for (const float* column : columns) {
      const Float value = abs(Float::load(column + i));
      finite &= is_finite(value);
      largest = max(largest, value);
    }
    const Mask kept = finite & inside;
    select(kept, Float(1.f)).store(weights_.kept + i);
    small = small && none(kept & (largest > kMaxSummedValue));
    if (all(kept)) return;
    dropped += wide::count(inside & !finite);
    for (float* column : columns) select(kept, Float::load(column + i)).store(column + i);
  });
  film.count_non_finite(dropped);
  return small;
}

/// Adds samples first … end - 1 to the pixels that the filter reaches from (x, y).
void FilmSamples::add_pixel(int x, int y, size_t first, size_t end,
                            const std::vector<float*>& columns, float weight, FilmTile& film) {
  for (int j = -reach_; j <= reach_; ++j) {
    for (int k = -reach_; k <= reach_; ++k) {
      const float* const wx = weights_.x[static_cast<size_t>(k + reach_)];
      const float* const wy = weights_.y[static_cast<size_t>(j + reach_)];
      const PixelWeights weights{wx, wy, weights_.kept, weight};
      for (size_t next = 0; next <= columns.size(); next += kColumnsAtOnce) {
        float* const* const from = columns.data() + next;
        float* const to = sums_.data() + next;
        switch (columns.size() - next) {
          case 0: sum_columns<0>(weights, first, end, from, to); break;
          case 1: sum_columns<1>(weights, first, end, from, to); break;
          case 2: sum_columns<2>(weights, first, end, from, to); break;
          case 3: sum_columns<3>(weights, first, end, from, to); break;
          default: sum_columns<kColumnsAtOnce>(weights, first, end, from, to);
        }
      }
      film.add_sums(x + k, y + j, {sums_.data(), columns.size()}, sums_[columns.size()]);
    }
  }
}

void FilmSamples::add(const PixelSamples& samples, const Columns2& position,
                      const std::vector<float*>& columns, FilmTile& film, float weight) {
  const size_t count = samples.count();
  if (exact_) {
    film.add_block(position, count, columns);
    return;
  }
  const bool sums_fit = drop_non_finite(count, columns, film);
  const size_t at_once = sums_fit ? samples.samples : 1;
  find_weights(samples, samples.x, position.x, weights_.x);
  find_weights(samples, samples.y, position.y, weights_.y);
  if (many_ && sums_fit) {
    many_->add(samples, position, columns, weights_, weight, film);
    return;
  }
  for (size_t p = 0; p < samples.pixels; ++p) {
    const size_t end = (p + 1) * samples.samples;
    for (size_t first = p * samples.samples; first < end; first += at_once) {
      add_pixel(static_cast<int32_t>(samples.x[p]), static_cast<int32_t>(samples.y[p]), first,
                first + at_once, columns, weight, film);
    }
  }
}

}  // namespace kinome::transport

// Vectorized sums of each pixel's samples.

#include "film_samples.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Sums of a pixel's samples have single precision until they are added to the film's. Values above
/// this one might overflow such a sum, and are added to the film one by one.
constexpr float kMaxSummed = 1e30f;
/// Maximum number of values of a sample that are summed at once: colour and alpha.
constexpr size_t kMaxColumns = 4;

}  // namespace

bool weighs_positions(const ReconstructionFilter& filter) {
  constexpr float kNearEdge = 0.4999f;
  return filter.radius() > 0.5f || filter.eval(0) != filter.eval(kNearEdge);
}

FilmSamples::FilmSamples(const ReconstructionFilter& filter, int values, size_t samples, bool exact)
    : filter_(filter),
      exact_(exact || static_cast<size_t>(values) > kMaxColumns),
      // For a sample anywhere in its pixel: see FilmTile::add.
      reach_(-static_cast<int>(std::floor(0.5f - filter.radius()))),
      arena_(samples + kBlockLanes),
      offset_(arena_.floats()),
      kept_(arena_.floats()),
      sums_(static_cast<size_t>(values)) {
  for (int k = -reach_; k <= reach_; ++k) {
    wx_.push_back(arena_.floats());
    wy_.push_back(arena_.floats());
  }
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
bool FilmSamples::leave_out_non_finite(size_t count, const std::vector<float*>& columns,
                                       FilmTile& film) {
  size_t dropped = 0;
  bool small = true;
  // Values beyond the samples become 0, too, because a pixel's last vector may reach there.
  for_lanes(count + kBlockLanes, [&](size_t i) {
    const Mask inside = first_lanes(std::min(count - std::min(i, count), kLanes));
    Float largest = 0.f;
    Mask finite = true;
    for (const float* column : columns) {
      const Float value = abs(Float::load(column + i));
      finite &= is_finite(value);
      largest = max(largest, value);
    }
    const Mask kept = finite & inside;
    select(kept, Float(1.f)).store(kept_ + i);
    small = small && none(kept & (largest > kMaxSummed));
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
      const float* const wx = wx_[static_cast<size_t>(k + reach_)];
      const float* const wy = wy_[static_cast<size_t>(j + reach_)];
      Float weights = 0.f;
      Float values[kMaxColumns] = {0.f, 0.f, 0.f, 0.f};
      for (size_t i = first; i < end; i += kLanes) {
        const Mask kept = first_lanes(std::min(end - i, kLanes)) & (Float::load(kept_ + i) > 0.f);
        const Float w = select(kept, weight * Float::load(wx + i) * Float::load(wy + i));
        weights += w;
        for (size_t c = 0; c < columns.size(); ++c) {
          values[c] = mul_add(w, Float::load(columns[c] + i), values[c]);
        }
      }
      for (size_t c = 0; c < columns.size(); ++c) sums_[c] = sum(values[c]);
      film.add_sums(x + k, y + j, sums_, sum(weights));
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
  const size_t at_once = leave_out_non_finite(count, columns, film) ? samples.samples : 1;
  find_weights(samples, samples.x, position.x, wx_);
  find_weights(samples, samples.y, position.y, wy_);
  for (size_t p = 0; p < samples.pixels; ++p) {
    const size_t end = (p + 1) * samples.samples;
    for (size_t first = p * samples.samples; first < end; first += at_once) {
      add_pixel(static_cast<int32_t>(samples.x[p]), static_cast<int32_t>(samples.y[p]), first,
                first + at_once, columns, weight, film);
    }
  }
}

}  // namespace kinome::transport

#pragma once

#include <functional>
#include <span>
#include <vector>

#include "kinome/color.h"
#include "kinome/columns.h"
#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Power of a sample value that a layer averages in addition to the values. `value` counts from the
/// sample's first value (the film's R), or is FilmChannel::kX, kY or kZ.
struct FilmPower {
  int value;
  int power;
  /// Returns the power for a sample with these values.
  double operator()(const float* values) const;
};

/// Samples of one tile, with a border as wide as the filter. Not thread-safe: used by one thread at
/// a time.
class KINOME_EXPORT FilmTile {
 public:
  FilmTile(const Rect& pixels, int layer, int values, const ReconstructionFilter& filter,
           const Rect& crop, std::vector<FilmPower> powers = {});
  /// Adds one sample at `position` (pixels of the full film). `values` has Film::value_count()
  /// entries. A sample with a non-finite value is counted and dropped.
  void add(const Vec2& position, std::span<const float> values);
  /// Adds `count` samples at any positions, as add() does; values[k][i] is value k of sample i.
  /// Filter weights come from eval_block().
  void add_block(const Columns2& position, size_t count, std::span<const float* const> values);
  /// Adds an unfiltered value to one pixel of this tile, for integrators that sample the filter
  /// themselves. Several values of a pixel are averaged by `weight` (> 0). Non-finite values are
  /// handled as in add().
  void add_pixel(int x, int y, std::span<const float> values, float weight = 1);
  /// Adds prefiltered sums (weight x value) and the sum of weights to pixel (x, y) of this tile or
  /// its border; other pixels are ignored. All sums must be finite: callers drop non-finite samples
  /// and report them by count_non_finite(). Not supported by layers with powers
  /// (Film::has_powers()).
  void add_sums(int x, int y, std::span<const float> sums, float weight);
  void count_non_finite(uint64_t samples) { non_finite_ += samples; }
  /// Adds light that arrives at `position` of the full film, inside or outside this tile. Pixels
  /// add it to their weighted means, scaled by the filter's weight divided by its integral over
  /// Film::sampled(). Only for layers with colour.
  void add_splat(const Vec2& position, const Rgb& value);
  /// Adds to the number of light paths. The film divides its splats by the total, or by 1 if this
  /// is never called.
  void add_light_paths(double count) { light_paths_ += count; }
  const Rect& pixels() const { return pixels_; }
  /// Index of the layer in the film, including Film::first_layer().
  int layer() const { return layer_; }
  /// Serialises the tile: calls `io` for each piece of its data. `io` copies the bytes, or
  /// overwrites them with those of the same tile from another process.
  void transfer(const std::function<void(void* bytes, size_t count)>& io);
  bool has_splats() const { return !splats_.empty(); }
  uint64_t non_finite() const { return non_finite_; }

 private:
  friend class Film;
  int stride() const { return values_ + static_cast<int>(powers_.size()) + 1; }
  Rect pixels_;   ///< pixels of the tile
  Rect covered_;  ///< pixels and border, clipped to the film
  int layer_;
  int values_;
  std::vector<FilmPower> powers_;
  const ReconstructionFilter* filter_;
  std::vector<double> data_;  ///< per pixel: sums of values, of their powers, and of weights
  struct Splat {
    Vec2 position;
    Rgb value;
  };
  std::vector<Splat> splats_;
  double light_paths_ = 0;
  uint64_t non_finite_ = 0;
};

}  // namespace kinome

#pragma once

#include <vector>

#include "arena.h"
#include "kinome/film.h"

namespace kinome::transport {

/// True if a sample's weight depends on its position in its pixel, or if it counts for other pixels,
/// too: for all filters but a box of one pixel.
bool weighs_positions(const ReconstructionFilter& filter);

/// Adds the samples of a block to a tile of the film, a pixel's at a time: each pixel that the
/// filter reaches from there gets their weighted sum. One per thread.
class FilmSamples {
 public:
  /// `values` a sample, as Film::value_count says.
  /// `exact`: sums are of double precision throughout, which takes many times as long. For numbers
  /// of things: the mean of equal ones is to be that number. And for
  /// layers of which powers are asked for (Film::has_powers).
  FilmSamples(const ReconstructionFilter& filter, int values, size_t samples, bool exact = false);

  /// `columns`: each value of the samples; a vector more than padded() can be written. Samples that
  /// are no number are counted and dropped, as FilmTile::add does. `weight` multiplies the filter's;
  /// it must be 1 if `exact`.
  void add(const PixelSamples& samples, const Columns2& position,
           const std::vector<float*>& columns, FilmTile& film, float weight = 1);

 private:
  void find_weights(const PixelSamples& samples, const uint32_t* first, const float* position,
                    const std::vector<float*>& weights);
  bool leave_out_non_finite(size_t count, const std::vector<float*>& columns, FilmTile& film);
  void add_pixel(int x, int y, size_t first, size_t end, const std::vector<float*>& columns,
                 float weight, FilmTile& film);

  const ReconstructionFilter& filter_;
  bool exact_;
  int reach_;  ///< pixels to each side
  Arena arena_;
  float* offset_;
  float* kept_;                      ///< 1, or 0 where a sample is dropped
  std::vector<float*> wx_, wy_;      ///< of the pixels -reach_ … reach_
  std::vector<float> sums_;
};

}  // namespace kinome::transport

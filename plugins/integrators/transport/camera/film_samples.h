#pragma once

#include <optional>
#include <vector>

#include "kinome/film.h"
#include "transport/blocks/arena.h"
#include "transport/camera/channel_sums.h"

namespace kinome::transport {

/// True if a sample's weight depends on its position in its pixel, or if it also contributes to
/// other pixels: for all filters except a box of one pixel.
bool weighs_positions(const ReconstructionFilter& filter);

/// Adds the samples of a block to a tile of the film, one pixel at a time. Each pixel within the
/// filter's radius gets one weighted sum of this pixel's samples. Samples of many values are added
/// by ChannelSums. Not thread-safe: use one per thread.
class FilmSamples {
 public:
  /// `values`: number of values of a sample (Film::value_count).
  /// `exact`: all sums have double precision, which takes many times as long. Needed if the mean of
  /// equal values must be exactly that value, such as an index, and for layers with powers
  /// (Film::has_powers).
  FilmSamples(const ReconstructionFilter& filter, int values, size_t samples, bool exact = false);

  /// `columns`: the values of the samples. They may be overwritten, up to a vector beyond padded().
  /// Samples that aren't finite are counted and dropped, as in FilmTile::add. `weight` multiplies
  /// the filter's weight; it must be 1 if `exact`.
  void add(const PixelSamples& samples, const Columns2& position,
           const std::vector<float*>& columns, FilmTile& film, float weight = 1);

 private:
  void find_weights(const PixelSamples& samples, const uint32_t* first, const float* position,
                    const std::vector<float*>& weights);
  bool drop_non_finite(size_t count, const std::vector<float*>& columns, FilmTile& film);
  void add_pixel(int x, int y, size_t first, size_t end, const std::vector<float*>& columns,
                 float weight, FilmTile& film);

  const ReconstructionFilter& filter_;
  bool exact_;
  int reach_;  ///< filter radius in whole pixels
  Arena arena_;
  float* offset_;
  FilterWeights weights_;
  std::vector<float> sums_;  ///< values and weight
  std::optional<ChannelSums> many_;  ///< for samples of many values
};

}  // namespace kinome::transport

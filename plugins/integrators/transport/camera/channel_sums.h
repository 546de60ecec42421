#pragma once

#include <vector>

#include "kinome/film.h"
#include "transport/blocks/arena.h"

namespace kinome::transport {

/// Filter weights of the samples of a block: for pixels -reach … reach from their own, one column
/// for each pixel along x, and along y.
struct FilterWeights {
  std::vector<float*> x, y;
  float* kept;  ///< 1, or 0 if a sample is dropped
};

/// Adds samples that have many values to the film, for filters wider than a pixel. Lanes of vectors
/// are values, not samples, so that sums need no reduction over lanes. The sums of neighbouring
/// pixels have single precision until they are added to the film's. Not thread-safe.
class ChannelSums {
 public:
  /// `reach`: filter radius in whole pixels. `values`: number of values of a sample.
  ChannelSums(const ReconstructionFilter& filter, int reach, size_t values);

  /// Arguments: see FilmSamples::add. All values must be finite.
  void add(const PixelSamples& samples, const Columns2& position,
           const std::vector<float*>& columns, const FilterWeights& weights, float weight,
           FilmTile& film);

 private:
  /// Samples of a pixel that contribute to the same pixels.
  struct Part {
    size_t x, y;  ///< first of these pixels in the footprint of all samples
    size_t count;
    uint32_t* samples;
  };

  void add_pixel(const PixelSamples& samples, size_t p, const Columns2& position,
                 const std::vector<float*>& columns, const FilterWeights& weights);
  void add_to_film(float weight, FilmTile& film) const;
  void find_parts(const PixelSamples& samples, size_t p, size_t begin, size_t count,
                  const Columns2& position, const float* kept);
  void transpose(const std::vector<float*>& columns, const float* kept, size_t begin, size_t count,
                 size_t first_value);
  void add_part(const Part& part, size_t begin, const FilterWeights& weights, float* sums) const;
  template <size_t kRows>
  void add_rows(const Part& part, size_t y, size_t begin, const FilterWeights& weights,
                float* sums) const;

  int reach_;
  size_t side_;    ///< width and height of the footprint of a pixel's samples
  size_t width_;   ///< width and height of the footprint of a part
  size_t values_;
  size_t stride_;  ///< padded number of values of a pixel, including the weight
  size_t max_pixels_;  ///< maximum number of pixels in reached_
  Arena arena_;
  float* rows_;   ///< values of each sample
  float* zeros_;  ///< values of the padding
  std::vector<Part> parts_;
  Arena sums_arena_;
  float* sums_;  ///< by pixel of reached_
  Rect reached_;
};

}  // namespace kinome::transport

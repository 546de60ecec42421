#pragma once

#include <string>
#include <vector>

#include "kinome/film.h"
#include "kinome/zeroed_array.h"

namespace kinome {

/// Layers and lanes of a film, and their sums. Layers count from 0, not from Film::first_layer().
struct Film::Data {
  explicit Data(const Film& owner) : film(owner) {}

  /// Sums of one layer in one lane.
  struct Sums {
    ZeroedArray<double> values;  ///< per pixel: values, their powers, the weight
    ZeroedArray<double> splats;  ///< R, G, B per pixel; empty until the first splat
    double light_paths = 0;
  };
  using Lane = std::vector<Sums>;  ///< indexed by layer
  struct Layer {
    std::vector<std::string> names;  ///< values beside the colour
    bool has_color = false;
    std::vector<FilmPower> powers;
  };

  /// Number of values of a layer.
  int values_of(size_t layer) const;
  size_t stride_of(size_t layer) const {
    return values_of(layer) + layers[layer].powers.size() + 1;
  }
  /// Returns the index of the channel's value among the values of its layer. X, Y and Z have no
  /// index; for them, returns channel.value.
  int index_of(const FilmChannel& channel) const;
  /// Returns the splats of `sums`, allocating zeros first if there are none.
  ZeroedArray<double>& splats_of(Sums& sums);
  /// Colour over lanes [first, end).
  Rgb color(size_t layer, size_t pixel, size_t first, size_t end) const;
  double splat_scale(size_t layer, size_t first, size_t end) const;
  /// Value of a channel that shows colour or a power of a value.
  float value_of(const FilmChannel& channel, size_t pixel) const;
  /// Means of values that are adjacent in a layer and whose channels are adjacent in the image.
  struct Run {
    size_t layer, stride, first_value;
    size_t count;  ///< 0: this is one channel that is no such mean; value_of() returns its value
  };
  /// Divides `channels` into runs.
  std::vector<Run> runs() const;
  /// Calls write(mean) with the mean over all lanes of each value of a run; 0 without samples.
  template <class Write>
  void for_each_mean(const Run& run, size_t pixel, const Write& write) const;
  /// Mean over all lanes of a layer's value; indices beyond the values are their powers.
  double mean(size_t layer, size_t pixel, size_t value) const;

  const Film& film;
  std::vector<Layer> layers;
  std::vector<FilmChannel> channels;
  std::vector<Lane> lanes = std::vector<Lane>(1);
  /// Per column and row of the crop window: 1 / (integral of the filter over the sampled area).
  std::vector<double> splat_columns, splat_rows;
};

}  // namespace kinome

#pragma once

#include <cstdint>
#include <vector>

#include "kinome/film.h"
#include "kinome/image.h"

namespace kinome {

/// Estimated variance of an image's colours, in squared colour units. Infinite if fewer than two
/// lanes have samples.
struct FilmNoise {
  static constexpr int kTile = 16;  ///< side in pixels; tiles start at the crop window's corner
  /// Channels "variance.R", "variance.G", "variance.B" (or "variance.Y") hold the variance of each
  /// pixel. "tile_variance.R", ... hold the variance of the mean over the pixel's tile.
  /// Neighbouring pixels may have correlated noise (filter, light paths), so pixel variances don't
  /// sum to a tile's.
  Image image;
  std::vector<double> variance_of_mean;  ///< variance of the image's mean: R, G, B or Y
  uint32_t renders = 0;  ///< number of lanes with samples, at the pixel with the fewest
};

/// Estimates the variance of the colours of Film::develop() from the differences between lanes.
KINOME_EXPORT FilmNoise film_noise(const Film& film);

/// Returns the image with the channels of another one of the same size after its own.
KINOME_EXPORT Image with_channels_of(const Image& image, const Image& other);

}  // namespace kinome

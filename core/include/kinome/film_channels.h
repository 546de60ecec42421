#pragma once

#include <span>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// Image channel beside the film's colour: the mean over a pixel's samples of one value of a film
/// layer, or of a power of it.
struct FilmChannel {
  /// Index of one of the layer's own values, or a component of the sample's colour: R, G, B, alpha,
  /// or CIE X, Y, Z. (Mitsuba takes second moments of X, Y, Z.)
  static constexpr int kR = -7, kG = -6, kB = -5, kA = -4, kX = -3, kY = -2, kZ = -1;

  std::string name;
  int layer = 0;
  int value = 0;
  int power = 1;  ///< exponent; splats are ignored if it is above 1
};
/// Returns one channel for each value of the layers, in order.
KINOME_EXPORT std::vector<FilmChannel> channels_of(
    const std::vector<std::vector<std::string>>& layers);

/// Sums of one layer in one lane of a film, in the film's own memory.
struct FilmSums {
  double* light_paths = nullptr;
  std::span<double> values;  ///< per pixel: sums of values and of their powers, then the weight
  std::span<double> splats;  ///< per pixel: R, G, B; empty if there are no splats
};

/// Sums of one layer in one lane of a film, for reading.
struct ConstFilmSums {
  double light_paths = 0;
  std::span<const double> values;  ///< as in FilmSums
  std::span<const double> splats;
};

}  // namespace kinome

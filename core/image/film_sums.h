#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kinome/film.h"

namespace kinome {

/// What a lane of a film has of one layer, where it lies in the film, as Film::transfer hands it
/// out.
struct FilmSums {
  double* light_paths = nullptr;
  std::span<double> values;  ///< of each pixel: sums of values and of their powers, then the weight
  std::span<double> splats;  ///< R, G, B of each pixel; empty: there are none
};

/// Of a film of one lane, by layer; valid until it is prepared anew. `with_splats`: which layers
/// are given room for splats, though they may have none yet; shorter than the layers where that is
/// known of the first ones alone. `non_finite`, unless it is nullptr: how many samples were
/// dropped.
std::vector<FilmSums> sums_of(Film& film, const std::vector<bool>& with_splats = {},
                              uint64_t** non_finite = nullptr);

/// What the film's sensor has its colours multiplied by (Film::set_response), which can't be asked
/// for: of a film that holds a sum of 1 with weight 1. The film is left as if just prepared.
float response_of(Film& film);

}  // namespace kinome

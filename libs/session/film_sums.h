#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kinome/film.h"

namespace kinome {

/// Sums of one layer in one lane of a film. The pointers refer to the film's own memory, as passed
/// by Film::transfer().
struct FilmSums {
  double* light_paths = nullptr;
  std::span<double> values;  ///< per pixel: sums of values and of their powers, then the weight
  std::span<double> splats;  ///< per pixel: R, G, B; empty if there are no splats
};

/// Returns the sums of each layer of a film with one lane. They are valid until Film::prepare().
/// Layers with `with_splats` set get memory for splats if they have none; the vector may be shorter
/// than the number of layers. Unless `non_finite` is nullptr, sets `*non_finite` to the address of
/// the film's counter of dropped samples.
std::vector<FilmSums> sums_of(Film& film, const std::vector<bool>& with_splats = {},
                              uint64_t** non_finite = nullptr);

/// Returns the factor of Film::set_response(), for which Film has no getter: develops a pixel with
/// the sum 1 and the weight 1. Discards the film's contents, as Film::prepare() does.
float response_of(Film& film);

}  // namespace kinome

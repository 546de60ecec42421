#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/film.h"

namespace kinome {

/// Description of the film of a part and of its sums, stored in the file's header.
struct PartFilm {
  std::vector<std::vector<std::string>> layers;
  std::vector<FilmChannel> channels;
  std::string sensor;     ///< index of the sensor in the scene
  std::string colors;     ///< hdrfilm's pixel_format
  std::string component;  ///< hdrfilm's component_format
  float response = 1;
  uint64_t non_finite = 0;
  std::vector<double> light_paths;  ///< by layer
  std::vector<bool> has_splats;     ///< by layer
  uint64_t hash = 0;                ///< FNV-1a hash of all sums
};

/// Returns the value of the attribute kinome:part_film: one name and its value per line.
std::string text_of(const PartFilm& film);
/// Parses text_of(). Throws std::runtime_error if the text is invalid.
PartFilm part_film_of(const std::string& text);

}  // namespace kinome

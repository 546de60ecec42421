#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/film.h"

namespace kinome {

/// What the sums of a part are of: texts and numbers of the header.
struct PartFilm {
  std::vector<std::vector<std::string>> layers;
  std::vector<FilmChannel> channels;
  std::string sensor;     ///< its index in the scene
  std::string colors;     ///< hdrfilm's pixel_format
  std::string component;  ///< hdrfilm's component_format
  float response = 1;
  uint64_t non_finite = 0;
  std::vector<double> light_paths;  ///< by layer
  std::vector<bool> has_splats;     ///< by layer
  uint64_t hash = 0;                ///< of all sums
};

/// As the attribute kinome:part_film: a word and its value a line.
std::string text_of(const PartFilm& film);
/// Throws std::runtime_error where the text is none of these, or makes no film.
PartFilm part_film_of(const std::string& text);

}  // namespace kinome

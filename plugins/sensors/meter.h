#pragma once

#include <string>

#include "camera.h"

/// Helpers of sensors that measure one value, or a few, instead of an image.
namespace kinome {

/// Throws if the film has several rows and columns, as Mitsuba does, because all pixels would show
/// the same.
inline void check_film_of_one_pixel(const Properties& props, const Film& film) {
  if (film.width() == 1 || film.height() == 1) return;
  throw props.error("film", "must have one pixel, because all would show the same, got " +
                                std::to_string(film.width()) + " x " +
                                std::to_string(film.height()));
}

/// Reads a direction and normalises it.
inline Vec3 read_direction(const Properties& props, const char* name) {
  const Vec3 direction = props.vector(name);
  if (!(glm::length(direction) > 0)) throw props.error(name, "must not be zero");
  return glm::normalize(direction);
}

}  // namespace kinome

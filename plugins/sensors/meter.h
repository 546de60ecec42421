#pragma once

#include <string>

#include "camera.h"

/// What sensors have in common that measure one number, or a few, and see no picture.
namespace kinome {

/// Rows of a parameter table that all sensors have.
#define KINOME_SENSOR_PARAMETERS                                                                   \
  {"shutter_open", ParameterType::kFloat, "0",                                                     \
   "start of the exposure; matters only for timed_sunsky"},                            \
      {"shutter_close", ParameterType::kFloat, "0", "its end"},                                    \
      {"film", ParameterType::kObject, nullptr, "hdrfilm if not given", false, Category::kFilm}, { \
    "sampler", ParameterType::kObject, nullptr, "independent if not given", false,                 \
        Category::kSampler                                                                         \
  }

/// As Mitsuba has it of a film whose pixels would all show the same.
inline void check_film_of_one_pixel(const Properties& props, const Film& film) {
  if (film.width() == 1 || film.height() == 1) return;
  throw props.error("film", "must have one pixel, since all would show the same, got " +
                                std::to_string(film.width()) + " x " +
                                std::to_string(film.height()));
}

/// A direction that the scene gives, as a unit vector.
inline Vec3 read_direction(const Properties& props, const char* name) {
  const Vec3 direction = props.vector(name);
  if (!(glm::length(direction) > 0)) throw props.error(name, "must not be zero");
  return glm::normalize(direction);
}

}  // namespace kinome

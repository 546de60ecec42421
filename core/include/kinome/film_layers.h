#pragma once

#include "kinome/film.h"

namespace kinome {

/// Shifts layer indices by `first` during its lifetime, in all functions that integrators call
/// (Film::value_count(), has_powers(), make_tile()). A nested integrator, which counts its layers
/// from 0, thus fills its own range of layers.
class FilmLayers {
 public:
  FilmLayers(Film& film, int first) : film_(film), before_(film.first_layer_) {
    film.first_layer_ += first;
  }
  ~FilmLayers() { film_.first_layer_ = before_; }
  FilmLayers(const FilmLayers&) = delete;
  FilmLayers& operator=(const FilmLayers&) = delete;

 private:
  Film& film_;
  int before_;
};

}  // namespace kinome

#pragma once

#include <optional>
#include <string>

#include "kinome/math.h"

namespace kinome::app {

/// Options of `kinome film` beside those of all renders.
struct FilmOptions {
  std::string path;  ///< "orbit", "ellipse" or the name of a file of keys
  int frames = 0;
  double rate = 25;           ///< frames per second
  int first = 0, last = 0;    ///< frames to render, both included
  glm::dvec2 angles{30, 10};  ///< half axes of an ellipse, in degrees: to the side, and up
  std::optional<glm::dvec3> target, up;  ///< nullopt: derived from the scene's sensor
};

}  // namespace kinome::app

#pragma once

#include <optional>
#include <string>

#include "kinome/math.h"

namespace kinome::app {

/// What `kinome film` asks for beside what all renders do.
struct FilmOptions {
  std::string path;  ///< "orbit", "ellipse" or the name of a file of keys
  int frames = 0;
  double rate = 25;           ///< frames a second
  int first = 0, last = 0;    ///< frames to render, both included
  glm::dvec2 angles{30, 10};  ///< half axes of an ellipse, in degrees: to the side, and up
  std::optional<glm::dvec3> target, up;  ///< in place of what the scene shows
};

}  // namespace kinome::app

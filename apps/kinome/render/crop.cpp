#include "render/crop.h"

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome::app {

void apply_crop(const Options& options, const Sensor& sensor) {
  if (!options.crop) return;
  const Rect& crop = *options.crop;
  Film& film = sensor.film();
  if (crop.x1 > film.width() || crop.y1 > film.height()) {
    throw Error(
        fmt::format("--crop {},{},{},{}: must be within the film's {}x{} pixels, but ends at "
                    "column {} and row {}",
                    crop.x0, crop.y0, crop.width(), crop.height(), film.width(), film.height(),
                    crop.x1, crop.y1));
  }
  film.set_crop(crop);
}

}  // namespace kinome::app

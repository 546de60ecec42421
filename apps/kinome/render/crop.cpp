#include "render/crop.h"

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome::app {
namespace {

/// Sets the crop window of any film. Films read it when they are prepared, and when they write.
class CroppedFilm : public Film {
 public:
  static void set(Film& film, const Rect& crop) {
    constexpr Rect Film::*kCrop = &CroppedFilm::crop_;
    film.*kCrop = crop;
  }
};

}  // namespace

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
  CroppedFilm::set(film, crop);
}

}  // namespace kinome::app

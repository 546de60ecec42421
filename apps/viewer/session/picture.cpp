#include "session/picture.h"

#include "kinome/error.h"
#include "kinome/image_files.h"
#include "output_files/file_writer.h"

namespace kinome::viewer {

std::optional<Ray> ray_through(const Picture& picture, const Vec2& film_position) {
  if (!picture.sensor) return std::nullopt;
  return picture.sensor->sample_ray(film_position, Vec2(0.5f));
}

std::optional<Vec2> place_on_film(const Picture& picture, const Vec3& point) {
  const auto seen = picture.sensor ? picture.sensor->connect(point, Vec2(0.5f)) : std::nullopt;
  return seen ? std::optional(seen->film_position) : std::nullopt;
}

Image read_picture(const std::string& path) {
  return lower_extension(path) == ".pfm" ? read_pfm(path) : read_exr(path);
}

void write_picture(const std::string& path, const Picture& picture) {
  const std::string extension = lower_extension(path);
  if (extension == ".png") return write_png(path, picture.image, 0);
  if (extension != ".exr") throw Error(Location{path}, "must end in .exr or .png");
  write_exr(path, picture.image, ExrSampleType::kFloat,
            {{"integrator", picture.integrator},
             {"samples", std::to_string(static_cast<long>(picture.samples))}});
}

}  // namespace kinome::viewer

// Renders the parts of an image.

#include "kinome/parts.h"

#include <fmt/format.h>

#include "session/part_file.h"
#include "kinome/error.h"
#include "kinome/integrator.h"
#include "kinome/log.h"
#include "session/film_render.h"

namespace kinome {
namespace {

/// Returns the sensor with the number of samples of one of `count` parts.
std::unique_ptr<Sensor> sensor_of_part(const Sensor& sensor, uint32_t count) {
  return sensor.with_sample_count(1 + (sensor.sampler().sample_count() - 1) / count);
}

/// Renders the parts [first, end) of `count` parts, each in a lane of its own. `fills_gaps`: see
/// FilmRender.
Image render_range(const Scene& scene, const Sensor& sensor, RenderContext& context, uint32_t first,
                   uint32_t end, uint32_t count, bool fills_gaps) {
  const std::unique_ptr<Sensor> of_part = sensor_of_part(sensor, count);
  const uint32_t samples = of_part->sampler().sample_count();
  const uint64_t total = uint64_t{samples} * count;
  const uint32_t requested = sensor.sampler().sample_count();
  if (total != requested) {
    const std::string text =
        fmt::format("{} parts with {} sample{} each have {} in total, but the scene requests {}",
                    count, samples, samples == 1 ? "" : "s", total, requested);
    if (count > requested) {
      log_warn(text);
    } else {
      log_info(text);
    }
  }
  RenderJob& job = context.job;
  FilmRender how;
  how.lanes = end - first;
  how.fills_gaps = fills_gaps;
  how.render = [&] {
    const auto share = [&](uint32_t part) { return 1. * (part - first) / (end - first); };
    for (uint32_t part = first; part < end && !job.cancelled(); ++part) {
      sensor.film().set_lane(part - first);
      job.begin_pass(1 + part, share(part), share(part + 1));
      scene.integrator().render(scene, *of_part, context);
      job.stats().samples += samples;
    }
    job.begin_pass(0, 0, 1);
  };
  return run_film_render(how, scene, sensor, context);
}

}  // namespace

PartRender::PartRender(const Scene& scene, const Sensor& sensor, const ImagePart& part)
    : scene_(scene), sensor_(sensor), part_(part) {
  const Film& film = sensor.film();
  if (film.file_extension() != ".exr") {
    throw Error(fmt::format("the scene's film writes {} files, which can't hold its sums",
                            film.file_extension()));
  }
  if (film.plugin() != "film/hdrfilm") {
    throw Error(fmt::format("the scene's film is a {}, but parts can be merged only for an hdrfilm",
                            film.plugin()));
  }
}

Image PartRender::render(RenderContext& context) const {
  return render_range(scene_, sensor_, context, part_.index, part_.index + 1, part_.count, false);
}

void PartRender::write(const std::string& path, const Image& image,
                       const ImageMetadata& metadata) const {
  PartFilm film;
  film.layers = scene_.integrator().layers();
  film.channels = scene_.integrator().channels();
  film.response = sensor_.film().response();
  size_t index = 0;
  while (scene_.sensors()[index].get() != &sensor_) ++index;
  film.sensor = std::to_string(index);
  write_part_file(path, sensor_.film(), std::move(film), part_, image, metadata);
}

Image render_all_parts(const Scene& scene, const Sensor& sensor, RenderContext& context,
                       uint32_t count) {
  return render_range(scene, sensor, context, 0, count, count, true);
}

ImageMetadata metadata_of_parts(uint32_t count) {
  return {{"kinome:parts", std::to_string(count)}};
}

}  // namespace kinome

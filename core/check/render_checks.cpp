// What makes sensors, films and integrators right: a small scene, rendered.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>

#include "check/block_memory.h"
#include "check/density_cells.h"
#include "check/subject.h"
#include "kinome/image.h"
#include "kinome/render_context.h"

namespace kinome::check {
namespace {

/// A ball on a floor that fills the picture: not all integrators show the sky or a lamp themselves.
constexpr const char* kLitScene =
    "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform></shape>"
    "<shape type='sphere'><point name='center' x='0' y='0' z='0.7'/><float name='radius' "
    "value='0.6'/><bsdf type='roughplastic'><float name='alpha' value='0.3'/></bsdf></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale value='0.7'/><rotate x='1' "
    "angle='180'/><translate x='2.6' z='3'/></transform><emitter type='area'><float name='radiance' "
    "value='5'/></emitter></shape><emitter type='constant'><float name='radiance' value='0.3'/>"
    "</emitter>";

/// A camera of 24 x 16 pixels; `sampler` and `film` are elements.
std::string camera(const std::string& film, int samples) {
  return fmt::format(
      "<sensor type='perspective'><float name='fov' value='36'/><transform name='to_world'>"
      "<lookat origin='0 -2 5' target='0 0 0' up='0 0 1'/></transform><sampler "
      "type='independent'><integer name='sample_count' value='{}'/></sampler>{}</sensor>",
      samples, film);
}

constexpr const char* kFilm =
    "<film type='hdrfilm'><integer name='width' value='24'/><integer name='height' value='16'/>"
    "<rfilter type='box'/></film>";

Image picture_of(const Scene& scene, uint64_t seed, unsigned threads, uint64_t order = 0) {
  RenderContext::Options options;
  options.threads = threads;
  options.seed = seed;
  options.tile_order_seed = order;
  RenderContext context(options);
  return render(scene, *scene.sensors().at(0), context);
}

bool has_same_bits(const Image& a, const Image& b) {
  return a.data.size() == b.data.size() &&
         (a.data.empty() ||
          std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0);
}

// ---- sensors

std::unique_ptr<Scene> scene_of_sensor(const Subject& subject) {
  const auto sensor = subject.make<Sensor>();
  const std::string nested =
      sensor->is_surface() ? "<shape type='sphere'><point name='center' x='0' y='0' z='3'/>" +
                                 subject.xml() + "</shape>"
                           : subject.xml();
  return subject.scene_of("<integrator type='direct'/>" + std::string(kLitScene) + nested);
}

Outcome sensor_rays(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 1);
  const Rect& crop = sensor.film().crop();
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const Columns2 film = memory.two(), lens = memory.two();
  for (size_t i = 0; i < count; ++i) {
    const Vec2 share = random.unit2();
    film.set(i, Vec2(crop.x0, crop.y0) + share * Vec2(crop.width(), crop.height()));
    lens.set(i, random.unit2());
  }
  std::vector<RayHit16> blocks(padded(count) / 16);
  for (RayHit16& block : blocks) reset(block.ray);
  sensor.sample_ray_block(film, lens, count, blocks.data());
  int different = 0, aperture = 0;
  for (size_t i = 0; i < count && outcome.passed; ++i) {
    const Ray ray = sensor.sample_ray(film.at(i), lens.at(i));
    const std::string where =
        fmt::format(", through ({:.5g}, {:.5g})", film.at(i).x, film.at(i).y);
    if (!is_finite(ray.o) || !is_finite(ray.d)) outcome.fail("a ray is not finite" + where);
    if (std::abs(glm::length(ray.d) - 1) > 1e-4f) {
      outcome.fail("a ray's direction is not of unit length" + where);
    }
    if (!(ray.tmin >= 0 && ray.tmax > ray.tmin)) outcome.fail("tmin and tmax hold nothing" + where);
    const Ray other = ray_of(&blocks[i / 16].ray, i % 16);
    const float size = 1 + glm::length(ray.o);
    different += !(glm::length(ray.o - other.o) <= 1e-4f * size &&
                   glm::length(ray.d - other.d) <= 1e-4f);
    const Ray by_middle = sensor.sample_ray(film.at(i), Vec2(0.5f));
    aperture += glm::length(ray.o - by_middle.o) > 1e-5f * size ||
                glm::length(ray.d - by_middle.d) > 1e-5f;
  }
  if (different * 200 > static_cast<int>(count)) {
    outcome.fail(fmt::format("sample_ray_block() has other rays than sample_ray() at {} of {} places",
                             different, count));
  }
  if (aperture > 0 && !sensor.needs_aperture_sample()) {
    outcome.fail("rays depend on `aperture`, which needs_aperture_sample() denies");
  }
  outcome.measured = fmt::format("{} rays: finite, unit, in blocks as by themselves", count);
  return outcome;
}

/// connect() finds again where the film's rays come by.
Outcome sensor_connect(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Sensor& sensor = *scene->sensors().at(0);
  Random random(subject.request().seed + 2);
  const Rect& crop = sensor.film().crop();
  int seen = 0, lost = 0;
  const int count = subject.samples(2000);
  for (int i = 0; i < count; ++i) {
    const Vec2 film = Vec2(crop.x0, crop.y0) +
                      random.unit2() * Vec2(crop.width(), crop.height());
    const Vec2 aperture = random.unit2();
    const Ray ray = sensor.sample_ray(film, aperture);
    const float distance = std::max(1.5f * ray.tmin, std::min(0.5f * ray.tmax, random.between(1, 8)));
    const auto found = sensor.connect(ray.at(distance), aperture);
    lost += !found;
    if (!found) continue;
    ++seen;
    const float size = static_cast<float>(std::max(crop.width(), crop.height()));
    if (!(glm::length(found->film_position - film) <= 2e-3f * size)) {
      outcome.fail(fmt::format("connect() sees a point of the ray through ({:.5g}, {:.5g}) at ({:.5g}, "
                               "{:.5g})",
                               film.x, film.y, found->film_position.x, found->film_position.y));
    }
    if (!(glm::length(found->d + ray.d) < 2e-3f)) {
      outcome.fail("connect() has a d that doesn't lead back along the ray");
    }
    if (!(found->weight > 0 && std::isfinite(found->weight))) {
      outcome.fail(fmt::format("connect() has the weight {}", found->weight));
    }
  }
  if (seen > 0 && lost * 50 > count) {
    outcome.fail(fmt::format("connect() doesn't see {} of {} points of its rays", lost, count));
  }
  outcome.measured = seen > 0 ? fmt::format("{} points of rays are seen where the rays come from", seen)
                              : "not offered: ptracer shows black";
  return outcome;
}

Outcome sensor_picture(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_sensor(subject);
  const Image image = picture_of(*scene, 1, 1);
  for (const float value : image.data) {
    if (!std::isfinite(value)) outcome.fail("a picture by `direct` has a value that is not finite");
  }
  outcome.measured = fmt::format("{} x {} pixels, all finite", image.width, image.height);
  return outcome;
}

// ---- films

Outcome film_file(const Subject& subject) {
  Outcome outcome;
  const auto scene = subject.scene_of("<integrator type='direct'/>" + std::string(kLitScene) +
                                      camera(subject.xml(), 1));
  const Film& film = scene->sensors().at(0)->film();
  const Image image = picture_of(*scene, 1, 1);
  const std::string extension = film.file_extension();
  if (extension.size() < 2 || extension[0] != '.') {
    outcome.fail("file_extension() is '" + extension + "', expected as '.exr'");
    return outcome;
  }
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("kinome-check-{}", static_cast<int>(getpid()));
  fs::create_directories(folder);
  const std::string path = (folder / "picture").string();
  film.write(path, image, {});
  std::error_code failed;
  const auto size = fs::file_size(path + extension, failed);
  if (failed || size == 0) {
    outcome.fail("write() has made no file, or adds no extension to a name without one");
  } else if (extension == ".exr" || extension == ".pfm") {
    const Image read = extension == ".exr" ? read_exr(path + extension) : read_pfm(path + extension);
    if (read.width != image.width || read.height != image.height) {
      outcome.fail(fmt::format("the file has {} x {} pixels, the picture {} x {}", read.width,
                               read.height, image.width, image.height));
    }
  }
  try {
    film.write((folder / "no/such/folder/picture").string(), image, {});
    outcome.fail("write() into a folder that isn't there is no error");
  } catch (const Error&) {
    // As it must.
  }
  fs::remove_all(folder, failed);
  outcome.measured = fmt::format("{} x {} pixels in {} bytes of {}", image.width, image.height, size,
                                 extension);
  return outcome;
}

// ---- integrators

std::unique_ptr<Scene> scene_of_integrator(const Subject& subject, const std::string& integrator,
                                           int samples) {
  return subject.scene_of(integrator + kLitScene + camera(kFilm, samples));
}

Outcome integrator_bits(const Subject& subject) {
  Outcome outcome;
  const auto scene = scene_of_integrator(subject, subject.xml(), 4);
  const Image one = picture_of(*scene, 1, 1);
  for (const float value : one.data) {
    if (!std::isfinite(value)) outcome.fail("a picture has a value that is not finite");
  }
  for (const unsigned threads : {2u, 3u}) {
    note_attempt(fmt::format("{} threads", threads));
    if (!has_same_bits(one, picture_of(*scene, 1, threads, threads))) {
      outcome.fail(fmt::format("the picture is another by {} threads than by one", threads));
    }
  }
  if (!has_same_bits(one, picture_of(*scene, 1, 1))) {
    outcome.fail("the same seed gives another picture the second time");
  }
  outcome.measured = "the same bits by 1, 2 and 3 threads, and again";
  return outcome;
}

/// Means and variances of each pixel's channels, of renders with different seeds.
std::vector<Estimate> estimates_of(const Scene& scene, int renders, uint64_t seed) {
  // Sums of 4 x 4 pixels are nearer to normal.
  constexpr int kSide = 4;
  std::vector<Moments> moments;
  for (int i = 0; i < renders; ++i) {
    const Image image = picture_of(scene, seed + static_cast<uint64_t>(i), 1);
    const int columns = (image.width + kSide - 1) / kSide, rows = (image.height + kSide - 1) / kSide;
    std::vector<double> sums(static_cast<size_t>(columns) * rows * 3);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          sums[3 * static_cast<size_t>(y / kSide * columns + x / kSide) + static_cast<size_t>(c)] +=
              double{image.at(x, y, c)};
        }
      }
    }
    moments.resize(sums.size());
    for (size_t k = 0; k < sums.size(); ++k) moments[k].add(sums[k]);
  }
  std::vector<Estimate> estimates;
  for (const Moments& m : moments) estimates.push_back({m.mean(), m.variance_of_mean()});
  return estimates;
}

Outcome integrator_light(const Subject& subject, double alpha) {
  Outcome outcome;
  const std::string& against = subject.request().against;
  if (against.empty()) {
    outcome.measured = "nothing to compare with: --against NAME is an integrator of the same light";
    return outcome;
  }
  // As many that a variance of their mean is known to some 10 %.
  const int renders = std::max(40, subject.samples(60));
  const auto own = estimates_of(*scene_of_integrator(subject, subject.xml(), 4), renders,
                                subject.request().seed + 100);
  const auto other =
      estimates_of(*scene_of_integrator(
                       subject, "<integrator type=\"" + against + "\"/>", 4),
                   renders, subject.request().seed + 10000);
  const Verdict verdict = z_test(own, other, alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) {
    double a = 0, b = 0;
    for (const Estimate& e : own) a += e.mean;
    for (const Estimate& e : other) b += e.mean;
    outcome.fail(fmt::format("its pictures are others than by '{}': {:.4g} times the light", against,
                             a / b));
  }
  return outcome;
}

}  // namespace

void add_sensor_checks(const Subject& subject, Plan& plan) {
  plan.add("rays", 0, [&](double) { return sensor_rays(subject); });
  plan.add("connect", 0, [&](double) { return sensor_connect(subject); });
  plan.add("picture", 0, [&](double) { return sensor_picture(subject); });
}

void add_film_checks(const Subject& subject, Plan& plan) {
  plan.add("file", 0, [&](double) { return film_file(subject); });
}

void add_integrator_checks(const Subject& subject, Plan& plan) {
  plan.add("bits", 0, [&](double) { return integrator_bits(subject); });
  plan.add("light", 1, [&](double alpha) { return integrator_light(subject, alpha); });
}

}  // namespace kinome::check

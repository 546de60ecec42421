// Checks of films and integrators, which render a small scene.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <unistd.h>

#include <fmt/format.h>

#include "kinome/image.h"
#include "kinome/image_files.h"
#include "kit/scenes/lit_scene.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Returns a camera with the XML element `film`.
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

bool has_same_bits(const Image& a, const Image& b) {
  return a.data.size() == b.data.size() &&
         (a.data.empty() ||
          std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0);
}

// ---- films

Outcome film_file(const Subject& subject) {
  Outcome outcome;
  const auto scene = subject.scene_of("<integrator type='direct'/>" + std::string(kLitScene) +
                                      camera(subject.xml(), 1));
  const Film& film = scene->sensors().at(0)->film();
  const Image image = render_image(*scene, 1, 1);
  const std::string extension = film.file_extension();
  if (extension.size() < 2 || extension[0] != '.') {
    outcome.fail("file_extension() is '" + extension + "', expected an extension like '.exr'");
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
    outcome.fail("write() creates no file, or doesn't append the extension to a name without one");
  } else if (extension == ".exr" || extension == ".pfm") {
    const Image read = extension == ".exr" ? read_exr(path + extension) : read_pfm(path + extension);
    if (read.width != image.width || read.height != image.height) {
      outcome.fail(fmt::format("the file has {} x {} pixels, expected {} x {}", read.width,
                               read.height, image.width, image.height));
    }
  }
  try {
    film.write((folder / "no/such/folder/picture").string(), image, {});
    outcome.fail("write() to a folder that doesn't exist throws no Error");
  } catch (const Error&) {  // as required
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
  const Image one = render_image(*scene, 1, 1);
  for (const float value : one.data) {
    if (!std::isfinite(value)) outcome.fail("the image has a value that is not finite");
  }
  for (const unsigned threads : {2u, 3u}) {
    note_attempt(fmt::format("{} threads", threads));
    if (!has_same_bits(one, render_image(*scene, 1, threads, threads))) {
      outcome.fail(fmt::format("the image with {} threads differs from that with one", threads));
    }
  }
  if (!has_same_bits(one, render_image(*scene, 1, 1))) {
    outcome.fail("a second render with the same seed gives a different image");
  }
  outcome.measured = "renders with 1, 2 and 3 threads, and a second one with 1 thread, bit by bit";
  return outcome;
}

/// Means and variances of the channels of parts of the image, then of all of it, over renders with
/// different seeds.
std::vector<Estimate> estimates_of(const Scene& scene, int renders, uint64_t seed) {
  // Sums of 4 x 4 pixels are closer to a normal distribution.
  constexpr int kSide = 4;
  std::vector<Moments> moments;
  for (int i = 0; i < renders; ++i) {
    const Image image = render_image(scene, seed + static_cast<uint64_t>(i), 1);
    const int columns = (image.width + kSide - 1) / kSide, rows = (image.height + kSide - 1) / kSide;
    const size_t all = static_cast<size_t>(columns) * rows * 3;
    std::vector<double> sums(all + 3);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          const auto value = double{image.at(x, y, c)};
          sums[3 * static_cast<size_t>(y / kSide * columns + x / kSide) + static_cast<size_t>(c)] +=
              value;
          sums[all + static_cast<size_t>(c)] += value;
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
    outcome.measured =
        "nothing to compare with: --against NAME names an integrator for the same light";
    return outcome;
  }
  // Enough renders to estimate the variance of their mean within about 10 %.
  const int renders = std::max(40, subject.samples(60));
  const auto own = estimates_of(*scene_of_integrator(subject, subject.xml(), 4), renders,
                                subject.request().seed + 100);
  const auto other =
      estimates_of(*scene_of_integrator(subject, subject.xml_against(), 4), renders,
                   subject.request().seed + 10000);
  const Verdict verdict = largest_z_test(own, other, alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) {
    double a = 0, b = 0;
    for (const Estimate& e : own) a += e.mean;
    for (const Estimate& e : other) b += e.mean;
    outcome.fail(fmt::format("its images differ from those of '{}': {:.4g} times the light",
                             against, a / b));
  }
  return outcome;
}

}  // namespace

void add_film_checks(const Subject& subject, Plan& plan) {
  plan.add("file", 0, [&](double) { return film_file(subject); });
}

void add_integrator_checks(const Subject& subject, Plan& plan) {
  plan.add("bits", 0, [&](double) { return integrator_bits(subject); });
  plan.add("light", 1, [&](double alpha) { return integrator_light(subject, alpha); });
}

}  // namespace kinome::check

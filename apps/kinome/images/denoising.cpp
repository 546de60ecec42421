#include "images/denoising.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/clock.h"
#include "crash.h"
#include "kinome/error.h"
#include "session/progressive.h"

namespace kinome::app {
namespace {

/// Header attribute with filter_weights() of the film of a part.
constexpr const char* kFilterOfPart = "kinome:filter_of_part";

/// Number of independent renders that estimate the noise, and the number of samples per pixel from
/// which on it is estimated. Below, the noisy image would hardly ever help, and independent renders
/// are less well stratified than one.
constexpr uint32_t kRendersForNoise = 4;
constexpr uint32_t kMinSamplesForNoise = 16;

/// Calls fn(), and says in its errors that they are about --denoise.
template <class Function>
auto about_option(const Function& fn) {
  try {
    return fn();
  } catch (const Error& error) {
    throw Error(fmt::format("--denoise: {}", error.what()));
  }
}

std::vector<float> weights_of(const DenoisingSetup& setup, const Film& film) {
  const auto found = setup.filters.find(&film);
  return found == setup.filters.end() ? std::vector{1.f} : filter_weights(*found->second);
}

/// Removes the filter of add_filter() from the header, and returns it; empty if there is none.
std::vector<float> take_filter(ImageMetadata& metadata) {
  std::vector<float> filter;
  const auto text = metadata.find(kFilterOfPart);
  if (text == metadata.end()) return filter;
  std::istringstream numbers(text->second);
  for (float weight = 0; numbers >> weight;) filter.push_back(weight);
  metadata.erase(text);
  return filter;
}

}  // namespace

Denoising::Denoising(const Options& options)
    : as_layer_(options.denoise_as_layer),
      keeps_variance_(options.renders > 0),
      denoiser_(about_option([&] { return open_image_denoise(options.threads); })) {}

Image Denoising::denoise(const Image& image, std::vector<float> filter) const {
  set_activity("denoising");
  return about_option([&] {
    return denoise_image(
        image, denoiser_,
        {.as_layer = as_layer_, .keeps_variance = keeps_variance_, .filter = std::move(filter)});
  });
}

Image Denoising::denoise(const Image& image, const DenoisingSetup& setup, const Film& film,
                         RenderStats& stats) const {
  if (!keeps_variance_) stats.renders = 0;
  return denoise(image, weights_of(setup, film));
}

Image Denoising::denoise(const Image& image, ImageMetadata& metadata) const {
  std::vector<float> filter = take_filter(metadata);
  if (filter.empty()) {
    throw Error("--denoise: the parts lack albedo and normals: render each with --denoise, too");
  }
  return denoise(image, std::move(filter));
}

double Denoising::measure(Image& image, const DenoisingSetup& setup, const Film& film) const {
  const Clock::time_point start = Clock::now();
  image = denoise(image, weights_of(setup, film));
  return seconds_since(start);
}

std::optional<Denoising> denoising_of(const Options& options) {
  if (!options.denoise || options.part > 0) return std::nullopt;
  return Denoising(options);
}

std::shared_ptr<DenoisingSetup> denoising_setup(const Options& options) {
  return options.denoise ? std::make_shared<DenoisingSetup>() : nullptr;
}

uint32_t renders_for_noise(const Options& options, const Sensor& sensor) {
  if (options.renders > 0 || !options.denoise || options.part > 0) return options.renders;
  if (options.parts > 0) return options.parts > 1 ? options.parts : 0;  // parts are independent
  const bool is_open = options.seconds > 0 || options.rel_mse > 0;
  if (!is_open && sensor.sampler().sample_count() < kMinSamplesForNoise) return 0;
  return std::max(kRendersForNoise, lanes_for({.rel_mse = options.rel_mse}, sensor.film()));
}

void add_filter(const DenoisingSetup& setup, const Film& film, ImageMetadata& metadata) {
  metadata[kFilterOfPart] = fmt::format("{:.9g}", fmt::join(weights_of(setup, film), " "));
}

void remove_guides(Image& image, ImageMetadata& metadata) {
  const std::vector<float> filter = take_filter(metadata);
  if (!filter.empty()) image = image_without_guides(image, filter);
}

}  // namespace kinome::app

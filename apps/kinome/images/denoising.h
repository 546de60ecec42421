#pragma once

#include <memory>
#include <optional>

#include "kinome/denoise.h"
#include "kinome/image.h"
#include "kinome/scene.h"
#include "kinome/scene_loader.h"
#include "kinome/stats.h"
#include "options/options.h"

namespace kinome::app {

/// Denoising of a command's images, for --denoise. Not thread-safe.
class Denoising {
 public:
  /// Loads the library, so that a missing one is reported before the render. Throws Error.
  explicit Denoising(const Options& options);

  /// Denoises the image of `film`, which was loaded with `setup`, and applies the film's filter.
  /// Clears RenderStats::renders unless the user requested the variance.
  Image denoise(const Image& image, const DenoisingSetup& setup, const Film& film,
                RenderStats& stats) const;
  /// Same for a merged image, with the filter of its header.
  Image denoise(const Image& image, ImageMetadata& metadata) const;
  /// Returns the seconds that denoising the image takes, and replaces it by the result.
  double measure(Image& image, const DenoisingSetup& setup, const Film& film) const;

 private:
  Image denoise(const Image& image, std::vector<float> filter) const;

  bool as_layer_;
  bool keeps_variance_;
  Denoiser denoiser_;
};

/// Returns Denoising if --denoise is given and the image isn't a part of another one, whose merging
/// denoises it; otherwise nullopt.
std::optional<Denoising> denoising_of(const Options& options);

/// Returns the changes of the scene for --denoise; nullptr without it.
std::shared_ptr<DenoisingSetup> denoising_setup(const Options& options);

/// Returns the number of independent renders from which the noise is estimated: that of --variance,
/// or a small one if --denoise needs the noise and there are enough samples; the number of parts if
/// all of them are rendered; otherwise 0.
uint32_t renders_for_noise(const Options& options, const Sensor& sensor);

/// Records the filter of a part's film in its header, for `kinome merge`.
void add_filter(const DenoisingSetup& setup, const Film& film, ImageMetadata& metadata);

/// Replaces a merged image of parts that were rendered with --denoise by the image that the scene
/// gives without it. Leaves images of other parts as they are.
void remove_guides(Image& image, ImageMetadata& metadata);

}  // namespace kinome::app

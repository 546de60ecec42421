#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "kinome/export.h"
#include "kinome/image.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {

/// Images that a denoiser reads. Each has R, G, B (or X, Y, Z) per pixel, row by row from the top.
struct DenoiserInput {
  int width = 0;
  int height = 0;
  std::vector<float> color;   ///< linear radiance, with independent noise in each pixel
  std::vector<float> albedo;  ///< between 0 and 1; empty if unknown
  std::vector<float> normal;  ///< unit vectors, or 0; empty if unknown
};

/// Returns the denoised colour, laid out like the input's. Throws Error.
using Denoiser = std::function<std::vector<float>(const DenoiserInput& input)>;

/// Loads Open Image Denoise 2, a library by Intel, and returns its filter for high dynamic range,
/// which denoises albedo and normal before it uses them. It runs on `threads` threads (0: one per
/// core).
///
/// The library is not linked, but opened at the first call. It is searched in this order:
/// - the file or folder that the environment variable KINOME_OIDN names (and nowhere else then);
/// - `library`, if it isn't "";
/// - the system's library path;
/// - the Python package `pyoidn`, in the active virtual environment, beside the first `python3` of
///   PATH, and in the user's own packages.
///
/// Throws Error, which says how to install the library, if it isn't found or has another major
/// version. Thread-safe.
KINOME_EXPORT Denoiser open_image_denoise(unsigned threads, const std::string& library = "");

/// Combines a noisy image with a denoised one, to lower the expected error, so that the result
/// converges to the noisy image's expectation. `variance` is that of `noisy`, in the same layout;
/// infinity if unknown. All images have R, G, B per pixel.
///
/// The result is d + a (r - d), for the noisy value r, the denoised value d, and a share
///
///     a = b² / (b² + v),      b² = max(0, mean of (r - d)² - mean of v)
///
/// where v is the variance of r, and b² estimates the squared bias of d: an average over 11 x 11
/// pixels and the channels, relative to the pixel's brightness. `a` minimises the expected squared
/// error if r and d are uncorrelated. v is the larger one of the pixel's own variance and the mean,
/// so that single bright samples (fireflies) stay removed. As the number of samples grows, v
/// approaches 0: then either `a` approaches 1, or d has no bias.
KINOME_EXPORT std::vector<float> combine_with_noisy(std::span<const float> noisy,
                                                    std::span<const float> variance,
                                                    std::span<const float> denoised, int width,
                                                    int height);

/// Returns the filter's weights at whole distances from a pixel's centre: 0, 1, 2 and so on.
KINOME_EXPORT std::vector<float> filter_weights(const ReconstructionFilter& filter);

/// Filters the pixels of an image along both axes, with weights by distance in pixels. At the
/// image's edges, the weights of the remaining pixels are scaled up. Channels whose names begin
/// with "variance.", "tile_variance." or "Crypto" are left as they are.
KINOME_EXPORT void filter_pixels(Image& image, std::span<const float> weights);

/// Returns the original scene's name of a channel of a scene that was loaded with DenoisingSetup;
/// "" if the original scene lacks the channel.
KINOME_EXPORT std::string scene_channel(const std::string& channel);

struct DenoiseOptions {
  /// Writes the denoised colour as channels "denoised.R", ".G", ".B" beside the noisy one.
  /// Otherwise, the denoised colour is the image's, and the noisy one is "noisy.R", ".G", ".B".
  bool as_layer = false;
  bool keeps_variance = false;  ///< keeps the channels of film_noise()
  /// filter_weights() of the filter that is applied to the result.
  std::vector<float> filter = {1.f};
};

/// Denoises the image of a scene that was loaded with DenoisingSetup. Uses combine_with_noisy() if
/// the image has the channels of film_noise(). The result has the channels that the scene has
/// without DenoisingSetup, and the layer of DenoiseOptions. Throws Error.
KINOME_EXPORT Image denoise_image(const Image& image, const Denoiser& denoise,
                                  const DenoiseOptions& options);

/// Returns the image that the same samples give without denoising: without albedo and normals, with
/// the scene's names of channels, and filtered with `filter` as in DenoiseOptions.
KINOME_EXPORT Image image_without_guides(const Image& image, std::span<const float> filter);

}  // namespace kinome

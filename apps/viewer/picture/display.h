#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "picture/comparison.h"

namespace kinome::viewer {

/// Selects what is displayed of an image and its reference.
enum class Shown { kPicture, kReference, kSplit, kDifference };

/// Settings for the conversion of images to display pixels. Not thread-safe.
struct Display {
  Tone tone;
  Shown shown = Shown::kPicture;
  std::shared_ptr<const Reference> reference;  ///< nullptr if there is none; displays kPicture
  float split = 0.5f;                          ///< fraction of the width that displays the image
  std::shared_ptr<const Image> difference;     ///< nullptr if it isn't computed yet
  Tone difference_tone;

  /// Converts an image to sRGB with 4 bytes per pixel. Resamples a reference of another size, for
  /// example beside a preview. Displays the image if there is no difference of its size.
  void map(const Image& picture, std::vector<uint8_t>& rgba) const;
};

/// Resamples to the nearest pixel.
Image resampled(const Image& image, int width, int height);

/// Result of a comparison with a reference.
struct Comparison {
  PictureErrors errors;
  double flip = 0;  ///< mean over the image
  std::shared_ptr<const Image> difference;
  std::string fault;  ///< error message if the comparison failed, otherwise ""
};

/// Compares an image, displayed with `tone`, with a reference. Takes about 0.1 s for 640x480
/// pixels. Doesn't throw; errors are in Comparison::fault.
Comparison compare(const Image& picture, const Reference& reference, Difference kind,
                   const Tone& tone);

}  // namespace kinome::viewer

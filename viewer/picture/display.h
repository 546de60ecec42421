#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "picture/comparison.h"

namespace kinome::viewer {

/// What of a picture and its reference is shown.
enum class Shown { kPicture, kReference, kSplit, kDifference };

/// How pictures become what is seen, with all that this depends on. Of one thread.
struct Display {
  Tone tone;
  Shown shown = Shown::kPicture;
  std::shared_ptr<const Reference> reference;  ///< nullptr: none, and kPicture is shown
  float split = 0.5f;                          ///< share of the width that shows the picture
  std::shared_ptr<const Image> difference;     ///< nullptr: none yet
  Tone difference_tone;

  /// sRGB, 4 bytes for each of the picture's pixels. A reference of another size, as beside a
  /// preview, is resampled; a difference of another size isn't shown, but the picture.
  void map(const Image& picture, std::vector<uint8_t>& rgba) const;
};

/// By the nearest pixel.
Image resampled(const Image& image, int width, int height);

/// What a comparison with a reference has found.
struct Comparison {
  PictureErrors errors;
  double flip = 0;  ///< mean over the picture
  std::shared_ptr<const Image> difference;
  std::string fault;  ///< why there is none of these; "": they are there
};

/// Compares what is shown by `tone`; takes a tenth of a second for 640x480 pixels. Throws nothing.
Comparison compare(const Image& picture, const Reference& reference, Difference kind,
                   const Tone& tone);

}  // namespace kinome::viewer

#pragma once

#include <cstdint>
#include <vector>

#include "kinome/export.h"
#include "kinome/image.h"

namespace kinome {

/// Image of 8-bit sRGB values, row by row with interleaved channels: grey or R, G, B, then alpha.
/// Colours aren't multiplied by alpha.
struct SrgbBytes {
  int width = 0;
  int height = 0;
  int colors = 3;  ///< 1 or 3
  bool has_alpha = false;
  std::vector<uint8_t> bytes;
};
/// Converts the colours of a linear image, scaled by 2^exposure, and its alpha if it has one. With
/// `keeps_alpha` unset, alpha is left out, so that the image is shown on black.
KINOME_EXPORT SrgbBytes srgb_bytes_of(const Image& image, float exposure, bool keeps_alpha = true);

}  // namespace kinome

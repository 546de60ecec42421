#include "image_files/srgb_bytes.h"

#include <algorithm>
#include <cmath>

#include "image_files/color_channels.h"
#include "kinome/color.h"

namespace kinome {
namespace {

/// Converts a linear value to 8-bit sRGB. NaN becomes 0.
uint8_t quantise(float linear) {
  if (!(linear > 0)) return 0;
  return static_cast<uint8_t>(std::lround(255 * linear_to_srgb(std::min(linear, 1.f))));
}
uint8_t quantise_alpha(float alpha) {
  if (!(alpha > 0)) return 0;
  return static_cast<uint8_t>(std::lround(255 * std::min(alpha, 1.f)));
}

}  // namespace

SrgbBytes srgb_bytes_of(const Image& image, float exposure, bool keeps_alpha) {
  const int alpha = keeps_alpha ? image.find_channel("A") : -1;
  SrgbBytes result{image.width, image.height, color_channel_count(image), alpha >= 0, {}};
  const int stride = result.colors + (alpha >= 0 ? 1 : 0);
  const float factor = std::exp2(exposure);
  result.bytes.reserve(static_cast<size_t>(image.width) * image.height * stride);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float a = alpha >= 0 ? image.at(x, y, alpha) : 1.f;
      // The colour of a film is premultiplied by alpha.
      const float scale = a > 0 && a < 1 ? factor / a : factor;
      for (int c = 0; c < result.colors; ++c) {
        result.bytes.push_back(quantise(image.at(x, y, c) * scale));
      }
      if (alpha >= 0) result.bytes.push_back(quantise_alpha(a));
    }
  }
  return result;
}

}  // namespace kinome

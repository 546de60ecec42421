#pragma once

#include "kinome/image.h"

namespace kinome {

/// Returns the number of colour channels, which come first in an image: 3, or 1 for luminance.
inline int color_channel_count(const Image& image) {
  return image.channel_count() >= 3 && image.channels[0] != "Y" ? 3 : 1;
}

}  // namespace kinome

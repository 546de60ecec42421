#pragma once

#include "kinome/image.h"

namespace kinome {

/// How many of an image's first channels are its colour: 3, or 1 for a luminance, whatever channels
/// of other layers come after it.
inline int color_channel_count(const Image& image) {
  return image.channel_count() >= 3 && image.channels[0] != "Y" ? 3 : 1;
}

}  // namespace kinome

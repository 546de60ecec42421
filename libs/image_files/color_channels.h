#pragma once

#include <string>

#include "kinome/error.h"
#include "kinome/image.h"

namespace kinome {

/// Returns the number of colour channels, which come first in an image: 3, or 1 for luminance.
inline int color_channel_count(const Image& image) {
  return image.channel_count() >= 3 && image.channels[0] != "Y" ? 3 : 1;
}

/// Throws Error for an image without pixels or channels, or whose values are missing.
inline void check_not_empty(const std::string& path, const Image& image) {
  const size_t values = static_cast<size_t>(image.width) * image.height * image.channels.size();
  if (image.width < 1 || image.height < 1 || image.channels.empty() ||
      image.data.size() != values) {
    throw Error("cannot write '" + path + "': the image is empty");
  }
}

}  // namespace kinome

#pragma once

#include <limits>
#include <string>
#include <string_view>

namespace kinome::openimageio {

/// Smallest and largest width and height of images in a format.
struct SizeLimits {
  int low = 1;
  int high = std::numeric_limits<int>::max();
  bool contain(int width, int height) const {
    return low <= width && width <= high && low <= height && height <= high;
  }
  /// Returns them as text: "from 1 to 65500 pixels along each axis".
  std::string text() const {
    const bool has_high = high < std::numeric_limits<int>::max();
    return (has_high ? "from " + std::to_string(low) + " to " + std::to_string(high)
                     : "at least " + std::to_string(low)) +
           " pixels along each axis";
  }
};

/// Returns the limits of a format, by OpenImageIO's name of it. Beyond them, OpenImageIO ends the
/// program ("jpeg"), writes files that can't be read ("jpeg2000", "gif"), or reports no reason
/// ("webp").
constexpr SizeLimits size_limits(std::string_view format) {
  if (format == "jpeg") return {1, 65500};
  if (format == "webp") return {1, 16383};
  if (format == "gif") return {1, 65535};
  if (format == "jpeg2000") return {32, std::numeric_limits<int>::max()};  // 5 levels of wavelets
  return {};
}

}  // namespace kinome::openimageio

#pragma once

#include <gtest/gtest.h>
#include <png.h>

#include <string>
#include <vector>

namespace kinome::test {

/// A PNG file with 8 bits per channel. Programs that use it link PNG::PNG.
struct Png {
  unsigned width = 0;
  unsigned height = 0;
  std::vector<png_byte> rgba;
};
inline Png read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, path.c_str())) << image.message;
  image.format = PNG_FORMAT_RGBA;
  Png png{image.width, image.height, std::vector<png_byte>(PNG_IMAGE_SIZE(image))};
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, png.rgba.data(), 0, nullptr));
  return png;
}

}  // namespace kinome::test

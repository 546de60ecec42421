#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "image_files/openimageio/size_limits.h"

/// Interface of the library libkinome_openimageio.so, which programs open on demand, because
/// OpenImageIO takes a quarter of a second to load. Its functions throw nothing.
namespace kinome::openimageio {

/// Abilities of an image format.
struct WriterTraits {
  bool is_linear = false;  ///< stores linear float values and any channels; otherwise 8-bit sRGB
  bool has_alpha = false;
  SizeLimits limits;  ///< kinome_write_image() must not be called for images beyond them
};

/// Pixels to write, row by row with interleaved channels: either bytes or floats.
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  const uint8_t* bytes = nullptr;  ///< sRGB; colours aren't multiplied by alpha
  const float* floats = nullptr;   ///< linear; colours are multiplied by alpha
  std::map<std::string, std::string> attributes;
};

/// Type of `kinome_find_image_writer`: returns whether files with this extension (".jpg") can be
/// written.
using FindWriter = bool(const char* extension, WriterTraits& traits);
/// Type of `kinome_write_image`: writes a file. On failure, returns false and sets `error`.
using WriteImage = bool(const char* path, const Pixels& pixels, std::string& error);

}  // namespace kinome::openimageio

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinome {

/// An image as stored in its file: 8-bit values as bytes, all others as floats (integers are scaled
/// to [0, 1]). One or three interleaved channels without alpha; rows start at the top.
struct StoredImage {
  int width = 0;
  int height = 0;
  int channels = 0;
  bool is_encoded = false;  ///< true for integers, which are sRGB-encoded
  std::vector<uint8_t> bytes;
  std::vector<float> floats;
  std::vector<std::string> unused;  ///< channels of the file that are ignored
};

/// Reads the file at `path`, whose contents are `bytes`. Returns false with a reason in `error` if
/// that fails, and false with an empty `error` if the reader does not support the format.
using ReadImageFunction = bool (*)(const char* path, const std::string& bytes, StoredImage& image,
                                   std::string& error);
inline constexpr const char* kReadImageSymbol = "kinome_read_image";
/// Libraries with that function, relative to a folder of plugins, in the order in which
/// LoadedImage tries them. The first one reads PNG, JPEG and Radiance. The other one reads what
/// OpenImageIO reads; it takes a quarter of a second to load, because Debian's OpenImageIO links
/// 260 libraries.
inline constexpr const char* kReadImageLibraries[] = {"../support/image_reader.so",
                                                      "../support/openimageio_reader.so"};

}  // namespace kinome

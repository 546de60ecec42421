#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinome {

/// A picture as its file has it: 8-bit values as bytes, all others as floats (integers scaled to
/// [0, 1]); one or three channels, interleaved, rows from the top; without alpha.
struct StoredImage {
  int width = 0;
  int height = 0;
  int channels = 0;
  bool is_encoded = false;  ///< integers, which stand for sRGB-encoded values
  std::vector<uint8_t> bytes;
  std::vector<float> floats;
  std::vector<std::string> unused;  ///< channels of the file that are left out
};

/// Reads any image through OpenImageIO. Loading that library costs a few tenths of a second, so it
/// is linked to a library of its own, which plugins open (open_image.h) only when they meet a file
/// that the core can't read. On failure returns false and says why in `error`.
using ReadImageFunction = bool (*)(const char* path, StoredImage& image, std::string& error);
inline constexpr const char* kReadImageSymbol = "kinome_read_image";
/// From a folder of plugins.
inline constexpr const char* kReadImageLibrary = "../support/image_reader.so";

}  // namespace kinome

#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>

#include "image_reader.h"

/// Readers of single formats, among which image_reader.cpp chooses. `bytes` is a whole file. They
/// throw std::runtime_error with the reason if the file is damaged or truncated.
namespace kinome {

void read_png(const std::string& bytes, StoredImage& image);
void read_jpeg(const std::string& bytes, StoredImage& image);
/// Radiance's format (.hdr, .pic), with any orientation, RGBE or XYZE. EXPOSURE and PRIMARIES in
/// the header are ignored, as in Mitsuba 3.
void read_radiance(const std::string& bytes, StoredImage& image);

inline constexpr const char* kTruncated = "truncated: it ends within the image";

/// Sets the image's size, before anything is allocated. Throws if a side is out of range, or if the
/// file is too small for `unpacked` bytes, which its format compresses by at most `best_ratio`.
inline void set_size(StoredImage& image, int64_t width, int64_t height, uint64_t unpacked,
                     uint64_t best_ratio, uint64_t file_size) {
  constexpr int64_t kMaxSide = 1 << 17;
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw std::runtime_error("its header has an invalid size: sides must be between 1 and " +
                             std::to_string(kMaxSide) + ", got " + size);
  }
  if (unpacked / best_ratio > file_size) {
    throw std::runtime_error("truncated: " + std::to_string(file_size) + " bytes can't hold " +
                             size + " pixels");
  }
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
}

/// Implements a ReadImageFunction by `read`, which returns false for an unsupported format.
template <class Read>
bool report_errors(std::string& error, const Read& read) {
  try {
    return read();
  } catch (const std::exception& e) {
    const std::string message = e.what();
    error = message.empty() ? "unknown error" : message.substr(0, message.find('\n'));
    return false;
  }
}

}  // namespace kinome

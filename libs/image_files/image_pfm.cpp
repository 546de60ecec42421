// Reads and writes portable float maps.

#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "image_files/color_channels.h"
#include "image_files/image_size.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "output_files/file_writer.h"

namespace kinome {
namespace {

float swap_bytes(float v) {
  return std::bit_cast<float>(__builtin_bswap32(std::bit_cast<uint32_t>(v)));
}

}  // namespace

void write_pfm(const std::string& path, const Image& image) {
  const int channels = color_channel_count(image);
  check_not_empty(path, image);
  FileWriter writer(path);
  constexpr bool kLittle = std::endian::native == std::endian::little;
  const std::string header =
      fmt::format("{}\n{} {}\n-1.0\n", channels == 3 ? "PF" : "Pf", image.width, image.height);
  writer.write(header.data(), header.size());
  std::vector<float> row(static_cast<size_t>(image.width) * channels);
  for (int y = image.height - 1; y >= 0; --y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        const float v = image.at(x, y, c);
        row[static_cast<size_t>(x) * channels + c] = kLittle ? v : swap_bytes(v);
      }
    }
    writer.write(row.data(), row.size() * sizeof(float));
  }
  writer.commit();
}

Image read_pfm(const std::string& path, const Location& requester) {
  const auto fail = [&](const std::string& why) {
    const Error error(Location{path}, "can't be read: " + why);
    return requester.file.empty() ? error : error.requested_by(requester);
  };
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) throw fail("no such file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail(std::strerror(errno));
  std::string magic;
  Image image;
  double scale = 0;
  file >> magic >> image.width >> image.height >> scale;
  if (!file || (magic != "PF" && magic != "Pf") || !std::isfinite(scale) || scale == 0) {
    throw fail("it is not a PFM file (expected PF or Pf, width, height, scale)");
  }
  if (image.width < 1 || image.height < 1 || image.width > kMaxSide || image.height > kMaxSide) {
    throw fail(fmt::format("the size in its header is invalid or too large: {} x {}", image.width,
                           image.height));
  }
  image.channels =
      magic == "PF" ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"};
  const size_t row = static_cast<size_t>(image.width) * image.channels.size();
  const size_t values = row * static_cast<size_t>(image.height);
  const uint64_t size = std::filesystem::file_size(path);
  // One white-space character precedes the data. It is "\r\n" if an editor has saved the header;
  // the file's size shows whether the '\n' belongs to the data.
  const bool is_return = file.get() == '\r';
  // tellg() fails if the file ends with its header.
  uint64_t begin = file ? static_cast<uint64_t>(file.tellg()) : size;
  if (is_return && size - begin == values * sizeof(float) + 1 && file.peek() == '\n') {
    file.get();
    ++begin;
  }
  if (size - begin < values * sizeof(float)) {
    throw fail(fmt::format("truncated: {} x {} pixels need {} bytes, got {}", image.width,
                           image.height, values * sizeof(float), size - begin));
  }
  image.data.resize(values);
  for (int y = image.height - 1; y >= 0; --y) {
    file.read(reinterpret_cast<char*>(&image.data[row * static_cast<size_t>(y)]),
              static_cast<std::streamsize>(row * sizeof(float)));
  }
  if (!file) throw fail("reading the pixels failed");
  const bool swapped = (scale < 0) != (std::endian::native == std::endian::little);
  const auto factor = static_cast<float>(std::abs(scale));
  for (float& v : image.data) v = (swapped ? swap_bytes(v) : v) * factor;
  return image;
}

}  // namespace kinome

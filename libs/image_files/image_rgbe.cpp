// Writes Radiance HDR images: 8 bits each of red, green and blue with a shared exponent (Ward 1991,
// "Real pixels"), with run-length encoded rows.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "image_files/color_channels.h"
#include "kinome/color.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "output_files/file_writer.h"

namespace kinome {
namespace {

using Bytes = std::vector<uint8_t>;

/// Truncates rather than rounds, as readers expect. Clamps to the largest representable value.
std::array<uint8_t, 4> to_rgbe(Rgb color) {
  constexpr float kMinValue = 1e-32f, kMaxValue = 0x1.fep126f;
  for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], kMaxValue) : 0.f;
  const float largest = max_component(color);
  if (largest < kMinValue) return {};
  int exponent;
  const float scale = std::frexp(largest, &exponent) * 256 / largest;
  const auto byte = [&](float v) { return static_cast<uint8_t>(std::min(v * scale, 255.f)); };
  return {byte(color.x), byte(color.y), byte(color.z), static_cast<uint8_t>(exponent + 128)};
}

/// Appends `bytes` with run-length encoding: a count before each run of equal bytes (plus 128) and
/// before each sequence of different ones.
void append_runs(const Bytes& bytes, Bytes& out) {
  constexpr size_t kMaxCount = 127, kMinRun = 4;
  const auto run_at = [&](size_t i) {
    size_t end = i;
    while (end < bytes.size() && end - i < kMaxCount && bytes[end] == bytes[i]) ++end;
    return end - i;
  };
  for (size_t i = 0; i < bytes.size();) {
    const size_t run = run_at(i);
    if (run >= kMinRun) {
      out.push_back(static_cast<uint8_t>(128 + run));
      out.push_back(bytes[i]);
      i += run;
      continue;
    }
    size_t end = i;
    while (end < bytes.size() && end - i < kMaxCount && run_at(end) < kMinRun) ++end;
    out.push_back(static_cast<uint8_t>(end - i));
    for (size_t k = i; k < end; ++k) out.push_back(bytes[k]);
    i = end;
  }
}

}  // namespace

void write_rgbe(const std::string& path, const Image& image) {
  check_not_empty(path, image);
  // Readers expect run-length encoding for these widths only.
  constexpr int kMinWidth = 8, kMaxWidth = 0x7fff;
  const bool has_runs = image.width >= kMinWidth && image.width <= kMaxWidth;
  const bool is_grey = color_channel_count(image) == 1;
  FileWriter writer(path);
  const std::string header = fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n",
                                         image.height, image.width);
  writer.write(header.data(), header.size());
  Bytes row;
  std::array<Bytes, 4> columns;
  for (int y = 0; y < image.height; ++y) {
    row.clear();
    for (Bytes& column : columns) column.clear();
    for (int x = 0; x < image.width; ++x) {
      const auto at = [&](int c) { return image.at(x, y, is_grey ? 0 : c); };
      const auto pixel = to_rgbe({at(0), at(1), at(2)});
      for (size_t c = 0; c < 4; ++c) columns[c].push_back(pixel[c]);
      if (!has_runs) row.insert(row.end(), pixel.begin(), pixel.end());
    }
    if (has_runs) {
      row = {2, 2, static_cast<uint8_t>(image.width >> 8), static_cast<uint8_t>(image.width)};
      for (const Bytes& column : columns) append_runs(column, row);
    }
    writer.write(row.data(), row.size());
  }
  writer.commit();
}

}  // namespace kinome

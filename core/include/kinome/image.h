#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kinome/error.h"
#include "kinome/math.h"

namespace kinome {

/// Rows top to bottom, channels interleaved.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", "albedo.R", …
  std::vector<float> data;            ///< width x height x channels

  Image() = default;
  /// `values` may be empty if `data` is set before any pixel is read or written.
  Image(int columns, int rows, std::vector<std::string> channel_names, std::vector<float> values)
      : width(columns),
        height(rows),
        channels(std::move(channel_names)),
        data(std::move(values)) {}

  int channel_count() const { return static_cast<int>(channels.size()); }
  float& at(int x, int y, int c) {
    return data[(static_cast<size_t>(y) * width + x) * channels.size() + c];
  }
  float at(int x, int y, int c) const {
    return data[(static_cast<size_t>(y) * width + x) * channels.size() + c];
  }
};

/// String attributes of an EXR file's header.
using ImageMetadata = std::map<std::string, std::string>;

/// Reads an OpenEXR file: scan lines or tiles, half, float or integers. Of several parts, reads the
/// one with the best colour. The colour comes first, as "R", "G", "B" or "Y", and then "A"; other
/// channels keep their names. It may be stored under these names, in lower case, as X, Y, Z, as
/// luminance with chroma, or in a layer ("View.Combined.R"); of several layers, one called
/// "Combined", "beauty" or similar is chosen, else the first one, with a warning. R, G, B become
/// linear Rec.709 if the attribute `chromaticities` gives other primaries (through XYZ, without
/// adaptation of the white, as in Mitsuba 3).
/// Throws Error at the file, asked for by `asker`, if it is missing, truncated, not an EXR or deep,
/// if its primaries span no colours, or if none of several parts has a colour.
KINOME_EXPORT Image read_exr(const std::string& path, const Location& asker = {},
                             ImageMetadata* metadata = nullptr);

/// Writers go to a temporary file in the same folder, then rename: `path` is whole or untouched.
/// Each throws Error where the folder can't be written or the disk is full. remove_temporary_files
/// deletes what an interrupted writer left; it is async-signal-safe.
/// What numbers of an EXR file are: half precision, single, or 32-bit integers of which the largest
/// is 1: less than 0 and more than 1 are clamped.
enum class ExrNumber { kHalf, kFloat, kUint };
/// `rect`: where the image lies in the full film (EXR's data window), if it is a crop.
KINOME_EXPORT void write_exr(const std::string& path, const Image& image, ExrNumber number,
                             const ImageMetadata& metadata, Vec2 crop_offset = Vec2(0.f),
                             Vec2 full_size = Vec2(0.f));
inline void write_exr(const std::string& path, const Image& image, bool half,
                      const ImageMetadata& metadata, Vec2 crop_offset = Vec2(0.f),
                      Vec2 full_size = Vec2(0.f)) {
  write_exr(path, image, half ? ExrNumber::kHalf : ExrNumber::kFloat, metadata, crop_offset,
            full_size);
}
/// Radiance's format, of the first three channels (or one, thrice): 8 bits each with an exponent in
/// common. What is negative becomes 0.
KINOME_EXPORT void write_rgbe(const std::string& path, const Image& image);
/// Portable float map of the first three channels (or one), little-endian.
KINOME_EXPORT void write_pfm(const std::string& path, const Image& image);
KINOME_EXPORT Image read_pfm(const std::string& path, const Location& asker = {});
/// 8-bit sRGB of the first three channels, multiplied by 2^exposure; alpha kept where there is one.
KINOME_EXPORT void write_png(const std::string& path, const Image& image, float exposure);
KINOME_EXPORT void write_text(const std::string& path, const std::string& text);
/// Waits until a file that was written is on the disk, and its folder knows of it. Throws Error.
KINOME_EXPORT void sync_file(const std::string& path);
KINOME_EXPORT void remove_temporary_files() noexcept;
/// Throws Error where a file at `path` could not be created now: the folder is missing or not
/// writable, or `path` is a folder. To be asked before a long render.
KINOME_EXPORT void check_writable(const std::string& path);

}  // namespace kinome

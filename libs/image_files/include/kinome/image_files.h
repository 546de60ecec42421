#pragma once

#include <string>

#include "kinome/image.h"

namespace kinome {

/// Sets the number of threads that compress or decompress a large OpenEXR file. 0, the default: one
/// per core. The bytes of files don't depend on it. Applies to the whole process.
KINOME_EXPORT void set_image_file_threads(unsigned threads);

/// Position of an image in the full film, in pixels: EXR's data and display windows.
struct ExrWindow {
  Vec2 crop_offset{0.f};  ///< of the image's upper left corner
  Vec2 full_size{0.f};    ///< of the film; 0 if the image is the whole film
};

/// Reads an OpenEXR file (scan lines or tiles; half, float or integers).
///
/// Colour channels come first, as "R", "G", "B" or "Y", followed by "A"; other channels keep their
/// names. In the file, colour may have these names, in upper or lower case, be stored as X, Y, Z or
/// as luminance and chroma, or be in a layer ("View.Combined.R"). Among several layers, reads one
/// named "Combined", "beauty" or similar, or else the first, with a warning. Among several parts,
/// reads the one with the best colour. Converts R, G, B to linear Rec.709 if the attribute
/// `chromaticities` gives other primaries (through XYZ, without white-point adaptation, as in
/// Mitsuba 3).
///
/// Sets `metadata` and `window` unless they are nullptr.
///
/// Throws Error at the file, referenced from `requester`, if it is missing, truncated, not an EXR,
/// or deep; if its primaries are degenerate; or if it has several parts but none with colour.
KINOME_EXPORT Image read_exr(const std::string& path, const Location& requester = {},
                             ImageMetadata* metadata = nullptr, ExrWindow* window = nullptr);

// All writers below write a temporary file in the same folder and rename it, so that `path` is
// either complete or unchanged. They throw Error if the folder is not writable or the disk is full.

/// Sample format of an EXR file: half or single precision, or 32-bit integers that map [0, 1] to
/// the full range and clamp other values.
enum class ExrSampleType { kHalf, kFloat, kUint };
/// Writes an OpenEXR file. `crop_offset` and `full_size` give the image's position in the full film
/// (EXR's data and display windows) if it is a crop.
KINOME_EXPORT void write_exr(const std::string& path, const Image& image, ExrSampleType number,
                             const ImageMetadata& metadata, Vec2 crop_offset = Vec2(0.f),
                             Vec2 full_size = Vec2(0.f));
/// Writes a Radiance (RGBE) file: the first three channels, or the only one as grey, with 8 bits
/// each and a common exponent. Negative values become 0.
KINOME_EXPORT void write_rgbe(const std::string& path, const Image& image);
/// Writes a portable float map (PFM) of the first three channels or the only one, little-endian.
KINOME_EXPORT void write_pfm(const std::string& path, const Image& image);
KINOME_EXPORT Image read_pfm(const std::string& path, const Location& requester = {});
/// Writes an 8-bit sRGB file of the first three channels, scaled by 2^exposure, and of alpha if
/// present.
KINOME_EXPORT void write_png(const std::string& path, const Image& image, float exposure);
/// Returns the bytes that write_png() would write.
KINOME_EXPORT std::string encode_png(const std::string& path, const Image& image, float exposure);

}  // namespace kinome

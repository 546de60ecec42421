#pragma once

#include <string>

#include "kinome/film.h"

/// File formats of images, chosen by the extension of the file's name: the film's own format, EXR,
/// PFM, RGBE and PNG, and all formats that OpenImageIO writes.
namespace kinome::app {

/// Returns the path of an image with `film_extension` appended, unless it has an extension. Throws
/// Error that begins with "-o" if images with its extension can't be written.
std::string image_path(const std::string& output, const std::string& film_extension);

/// Returns true if images with this extension store channels beside colour and alpha.
/// `film` as for write_image().
bool stores_channels(const std::string& extension, const Film* film);

/// Returns true if images with this extension have 8-bit sRGB values, which depend on the exposure.
/// `film` as for write_image().
bool stores_srgb(const std::string& extension, const Film* film);

/// Warns if the format of this path doesn't store the channels that the image has beside colour and
/// alpha. `film` as for write_image().
void warn_of_lost_channels(const Image& image, const std::string& path, const Film* film);

/// Throws Error that begins with "-o" if the format of this path can't store images of this size.
void check_image_size(const std::string& path, int width, int height);

/// Writes an image in the format of its extension: by the film if it is the film's own or "".
/// `film` may be nullptr for an image that doesn't come from a render. 8-bit
/// formats get sRGB values, scaled by 2^exposure, and formats of floats linear ones. Throws Error.
void write_image(const std::string& path, const Film* film, const Image& image,
                 const ImageMetadata& metadata, float exposure);

}  // namespace kinome::app

#pragma once

#include <memory>
#include <string>

#include "session/part_film.h"
#include "kinome/film.h"
#include "kinome/image.h"
#include "kinome/parts.h"
#include "kinome/plugin_registry.h"

/// Files of an image's parts. Such an EXR file has two EXR parts:
/// - The image of this part, as its film writes it. The attribute kinome:part is the part's number
///   ("3/16"), and kinome:part_film describes the sums (see PartFilm).
/// - "sums", the film's sums. Each double is stored as two channels of 32-bit integers, its upper
///   and its lower half: "0.2.high" and "0.2.low" are the third value of layer 0.
namespace kinome {

struct PartHeader {
  std::string path;
  ImagePart part;
  PartFilm film;
  Rect crop;
  int width = 0, height = 0;  ///< of the full film
  ImageMetadata metadata;     ///< of the image, without the attributes stored in this struct
};

/// Throws Error if the file can't be read or isn't a part.
KINOME_EXPORT PartHeader read_part_header(const std::string& path);

/// Creates a film that is prepared like the part's film, with this number of lanes.
KINOME_EXPORT std::shared_ptr<Film> make_film_of_part(const PartHeader& header,
                                                      PluginRegistry& registry, uint32_t lanes = 1);

/// Adds the file's sums to those of a film from make_film_of_part(), in the lane of set_lane().
/// Throws Error if they can't be read or their checksum is wrong; the film's contents are then
/// undefined.
KINOME_EXPORT void add_part(const PartHeader& header, Film& film);

/// Writes a part. `of` describes the film; this function sets its fields about the sums:
/// non_finite, light_paths, has_splats, hash, component and colors.
void write_part_file(const std::string& path, Film& film, PartFilm of, const ImagePart& part,
                     const Image& image, ImageMetadata metadata);

}  // namespace kinome

#pragma once

#include <memory>
#include <string>

#include "image/part_film.h"
#include "kinome/film.h"
#include "kinome/image.h"
#include "kinome/parts.h"
#include "kinome/plugin_registry.h"

/// Files of parts: EXR files of two pictures. The first is the part's, as its film writes it, with
/// an attribute kinome:part ("3/16") and one, kinome:part_film, that tells what the sums are of.
/// The second, "sums", has two channels of 32-bit integers for each of the film's numbers, its
/// upper and its lower half: "0.2.high" and "0.2.low" are of layer 0's third.
namespace kinome {

struct PartHeader {
  std::string path;
  PicturePart part;
  PartFilm film;
  Rect crop;
  int width = 0, height = 0;  ///< of the full film
  ImageMetadata metadata;     ///< of the picture, but for what is here
};

/// Throws Error where the file can't be read, or is of no part.
KINOME_EXPORT PartHeader read_part_header(const std::string& path);

/// A film that is prepared as the parts' was.
KINOME_EXPORT std::shared_ptr<Film> make_film_of_part(const PartHeader& header,
                                                      PluginRegistry& registry);

/// Adds the file's sums to those of such a film. Throws Error where they can't be read, or aren't
/// those that were written: the film is of no use then.
KINOME_EXPORT void add_part(const PartHeader& header, Film& film);

/// `film` tells what the sums are of; what it says of themselves is found out here.
void write_part_file(const std::string& path, Film& film, PartFilm of, const PicturePart& part,
                     const Image& image, ImageMetadata metadata);

}  // namespace kinome

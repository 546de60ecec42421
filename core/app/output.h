#pragma once

#include <string>
#include <vector>

#include "kinome/checkpoint.h"
#include "kinome/film.h"
#include "kinome/parts.h"
#include "options.h"

namespace kinome::app {

/// Where the picture goes, and with --png the PNG beside it.
struct Output {
  std::string picture;  ///< "": nowhere, there is only the PNG
  std::string png;      ///< "": none

  std::vector<std::string> files() const {
    if (picture.empty()) return {png};
    return png.empty() ? std::vector{picture} : std::vector{picture, png};
  }
  const std::string& name() const { return picture.empty() ? png : picture; }
};

/// Returns the path of the PNG that --png adds to a picture.
std::string png_beside(const std::string& picture);
/// Before anything is loaded: the film will choose the extension, but not the folder. Throws Error
/// where nothing can be written there.
void check_output_folder(const Options& options);
/// Before anything is rendered. Throws Error where the film can't write what is asked for, or not
/// there.
Output choose_output(const Options& options, const Film& film);
/// Seconds that it will take to write such a picture: by what it takes to write some of its rows.
double writing_seconds(const Options& options, const Film& film, const Image& picture,
                       const Output& output);
/// Where it can't be written, the checkpoint, if there is one, is left as it is. `part`: that the
/// picture is; nullptr: it is whole.
void write_picture(const Options& options, Film& film, const Image& image,
                   const ImageMetadata& metadata, const Output& output, Checkpoint* checkpoint,
                   const PartRender* part = nullptr);
/// Of a picture that is whole, and written: once that is on the disk.
void remove_checkpoint(Checkpoint& checkpoint, const Output& output);

}  // namespace kinome::app

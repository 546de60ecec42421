#pragma once

#include <string>
#include <vector>

#include "kinome/checkpoint.h"
#include "kinome/film.h"
#include "kinome/instruction_set.h"
#include "kinome/parts.h"
#include "kinome/scene.h"
#include "options/options.h"

namespace kinome::app {

/// Paths of an image's files.
struct Output {
  std::string image;  ///< the film's file; "" if only the PNG is written
  std::string png;    ///< "" if none is written

  std::vector<std::string> files() const {
    if (image.empty()) return {png};
    return png.empty() ? std::vector{image} : std::vector{image, png};
  }
  const std::string& name() const { return image.empty() ? png : image; }
};

/// Returns the path of the PNG that --png adds to an image.
std::string png_beside(const std::string& image);
/// Throws Error if the output can't be written. Called before the scene is loaded, whose film sets
/// the extension but not the folder.
void check_output_folder(const Options& options);
/// Throws Error if a denoised image can't be written with this extension (with dot, or "").
void check_format_of_denoised(const Options& options, const std::string& extension);
/// Returns the output files. Throws Error if the film doesn't support them or they can't be
/// written.
Output choose_output(const Options& options, const Film& film);
/// Estimates the seconds for writing an image from the time for writing some of its rows.
double writing_seconds(const Options& options, const Film& film, const Image& image,
                       const Output& output);
/// Writes the image, or a `part` of it (nullptr for a whole image). If that fails, `checkpoint`
/// (which may be nullptr) keeps the samples.
void write_image_files(const Options& options, Film& film, const Image& image,
                       const ImageMetadata& metadata, const Output& output, Checkpoint* checkpoint,
                       const PartRender* part = nullptr);
/// Removes the checkpoint of a complete image that has been written, after syncing the image to
/// disk.
void remove_checkpoint(Checkpoint& checkpoint, const Output& output);

/// Returns the value of --part, "3/16" or "all/16"; "" without --part.
std::string part_text(const Options& options);

/// Returns everything that the bits of the image depend on, except files that the scene names.
Checkpoint::Identity identity_of(const Options& options, const Scene& scene, const Sensor& sensor,
                                 InstructionSet instruction_set);

}  // namespace kinome::app

#include "images/output.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <future>

#include <fmt/format.h>

#include "images/image_formats.h"
#include "kinome/image_files.h"
#include "kinome/output_files.h"
#include "output_files/file_writer.h"
#include "session/scratch_folder.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Returns a suffix such as "-part03of16", by which names sort in the order of parts.
std::string suffix_of_part(const Options& options) {
  if (options.part == 0) return "";
  const size_t digits = std::to_string(options.parts).size();
  return fmt::format("-part{:0{}}of{}", options.part, digits, options.parts);
}

/// Returns the path of the image: that of -o, or one beside the scene file, with the film's
/// extension. Throws Error for the extension of an unknown image format.
std::string output_path(const Options& options, const std::string& extension) {
  if (!options.output.empty()) return image_path(options.output, extension);
  const std::string stem = fs::path(options.scene).replace_extension("").string();
  return stem + suffix_of_part(options) + extension;
}

}  // namespace

std::string png_beside(const std::string& image) {
  return is_null_device(image) ? image : fs::path(image).replace_extension(".png").string();
}

void check_output_folder(const Options& options) {
  std::error_code ignored;
  if (!fs::exists(options.scene, ignored)) return;  // the loader reports that
  if (options.output.empty()) {
    check_writable(fs::path(options.scene).replace_extension(".exr").string());
  } else {
    const bool whole = fs::is_directory(options.output, ignored) ||
                       fs::is_other(options.output, ignored) ||
                       fs::path(options.output).has_extension();
    check_writable(whole ? options.output : options.output + ".exr");
  }
}

void check_format_of_denoised(const Options& options, const std::string& extension) {
  if (options.denoise && !extension.empty() && extension != ".exr") {
    throw Error(fmt::format(
        "--denoise: needs an .exr file; {} files can't store the noisy image beside the "
        "denoised one",
        extension));
  }
}

Output choose_output(const Options& options, const Film& film) {
  Output output;
  output.image = options.inspect && lower_extension(options.output) == ".png"
                     ? options.output
                     : output_path(options, film.file_extension());
  const std::string extension = lower_extension(output.image);
  if (options.renders > 0 && !extension.empty() && extension != ".exr") {
    throw Error(
        fmt::format("--variance: needs an .exr file; {} files store only colour", extension));
  }
  check_format_of_denoised(options, extension);
  if (options.part > 0 && !extension.empty() && extension != film.file_extension()) {
    throw Error(fmt::format("--part: a part is an {} file, for kinome merge, not {}",
                            film.file_extension(), extension));
  }
  // Then, the image is a PNG already.
  if (options.png && extension != ".png") output.png = png_beside(output.image);
  const bool has_two = !output.png.empty() && !options.inspect && !is_null_device(output.image);
  if (has_two && are_written_to_one_file(output.image, output.png)) {
    throw Error(fmt::format("--png: '{}' and '{}' are the same file", output.image, output.png));
  }
  if (!options.inspect && !is_null_device(output.image)) {
    check_image_size(output.image, film.crop().width(), film.crop().height());
  }
  for (const std::string& file : output.files()) check_writable(file);
  return output;
}

double writing_seconds(const Options& options, const Film& film, const Image& image,
                       const Output& output) {
  if (is_null_device(output.name())) return 0;
  constexpr int kRows = 64;
  Image strip{
      image.width, std::min(image.height, std::max(kRows, image.height / 16)), image.channels, {}};
  const size_t row = static_cast<size_t>(image.width) * image.channels.size();
  const auto first =
      image.data.begin() + static_cast<std::ptrdiff_t>(row * ((image.height - strip.height) / 2));
  strip.data.assign(first, first + static_cast<std::ptrdiff_t>(row * strip.height));
  const ScratchFolder scratch(output.name());
  const Clock::time_point start = Clock::now();
  if (!output.image.empty()) {
    const std::string extension = lower_extension(output.image);
    write_image(scratch.file("timing" + (extension.empty() ? film.file_extension() : extension)),
                &film, strip, {}, options.exposure);
  }
  if (!output.png.empty()) write_png(scratch.file("timing.png"), strip, options.exposure);
  const std::chrono::duration<double> used = Clock::now() - start;
  return used.count() * image.height / strip.height;
}

void write_image_files(const Options& options, Film& film, const Image& image,
                       const ImageMetadata& metadata, const Output& output, Checkpoint* checkpoint,
                       const PartRender* part) {
  if (is_null_device(output.name())) return;
  try {
    std::future<std::string> png;
    if (!output.png.empty()) {
      // With one thread, get() encodes it.
      constexpr auto kAnyThread = std::launch::async | std::launch::deferred;
      png = std::async(options.threads == 1 ? std::launch::deferred : kAnyThread,
                       [&] { return encode_png(output.png, image, options.exposure); });
    }
    if (part) {
      part->write(output.image, image, metadata);
    } else if (!output.image.empty()) {
      write_image(output.image, &film, image, metadata, options.exposure);
    }
    if (png.valid()) write_text(output.png, png.get());
  } catch (...) {
    if (checkpoint) checkpoint->close(film);  // keeps all samples
    throw;
  }
}

void remove_checkpoint(Checkpoint& checkpoint, const Output& output) {
  for (const std::string& written : output.files()) sync_file(written);
  checkpoint.remove();
}

std::string part_text(const Options& options) {
  if (options.parts == 0) return "";
  return (options.part == 0 ? "all" : std::to_string(options.part)) + "/" +
         std::to_string(options.parts);
}

Checkpoint::Identity identity_of(const Options& options, const Scene& scene, const Sensor& sensor,
                                 InstructionSet instruction_set) {
  size_t index = 0;
  while (scene.sensors()[index].get() != &sensor) ++index;
  const Rect& crop = sensor.film().crop();
  const bool is_at_corner = crop.x0 == 0 && crop.y0 == 0;
  return {
      {"version", KINOME_VERSION},
      {Checkpoint::kScene, scene.hash()},
      {"sensor", std::to_string(index)},
      {"image size", fmt::format("{}x{}{}", crop.width(), crop.height(),
                                 is_at_corner ? "" : fmt::format(" at {},{}", crop.x0, crop.y0))},
      {"seed", std::to_string(options.seed)},
      {"--variance", std::to_string(options.renders)},
      {"--error", fmt::format("{}", options.rel_mse)},
      {"--part", part_text(options)},
      {"--denoise", options.denoise_as_layer ? "layer"
                    : options.denoise        ? "given"
                                             : ""},
      {"--isa", to_string(instruction_set)}};
}

}  // namespace kinome::app

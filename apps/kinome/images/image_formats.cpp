#include "images/image_formats.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "image_files/openimageio/openimageio_writer.h"
#include "image_files/srgb_bytes.h"
#include "kinome/color.h"
#include "kinome/error.h"
#include "kinome/image_files.h"
#include "kinome/log.h"
#include "kinome/output_files.h"
#include "output_files/file_writer.h"
#include "own_library.h"
#include "session/scratch_folder.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;

/// Extensions of formats that Kinome writes without OpenImageIO.
constexpr const char* kExr = ".exr";
constexpr const char* kPfm = ".pfm";
constexpr const char* kPng = ".png";
constexpr const char* kRadiance[] = {".hdr", ".rgbe"};

bool is_radiance(const std::string& extension) {
  return extension == kRadiance[0] || extension == kRadiance[1];
}

/// Functions of libkinome_openimageio.so, which is loaded once.
struct OpenImageIo {
  openimageio::FindWriter* find = nullptr;
  openimageio::WriteImage* write = nullptr;
  std::string failure;  ///< why the library can't be loaded, or ""
};
const OpenImageIo& open_image_io() {
  static const OpenImageIo functions = [] {
    void* const library = open_own_library("libkinome_openimageio.so", RTLD_NOW | RTLD_LOCAL);
    if (!library) return OpenImageIo{nullptr, nullptr, dlerror()};
    return OpenImageIo{
        reinterpret_cast<openimageio::FindWriter*>(dlsym(library, "kinome_find_image_writer")),
        reinterpret_cast<openimageio::WriteImage*>(dlsym(library, "kinome_write_image")), ""};
  }();
  return functions;
}

/// True for the extensions of formats that store grey only.
bool is_grey(const std::string& extension) {
  return extension == ".pgm" || extension == ".pbm";
}

/// Returns the luminance of an image.
Image luminance_of(const Image& image) {
  const int red = image.find_channel("R"), green = image.find_channel("G"),
            blue = image.find_channel("B"), grey = image.find_channel("Y");
  if (grey < 0 && (red < 0 || green < 0 || blue < 0)) return image;  // the writer reports that
  Image result{image.width, image.height, {"Y"}, {}};
  const size_t stride = image.channels.size();
  for (size_t at = 0; at < image.data.size(); at += stride) {
    const auto value = [&](int channel) { return image.data[at + static_cast<size_t>(channel)]; };
    result.data.push_back(grey >= 0 ? value(grey)
                                    : luminance(Rgb(value(red), value(green), value(blue))));
  }
  return result;
}

/// Returns the abilities of a format of OpenImageIO; nullopt if it is unknown.
std::optional<openimageio::WriterTraits> traits_of(const std::string& extension) {
  openimageio::WriterTraits traits;
  const OpenImageIo& library = open_image_io();
  if (!library.find || !library.find(extension.c_str(), traits)) return std::nullopt;
  return traits;
}

/// True for names such as "image.0007" and "image.v2", whose extension is the number of a frame or
/// a version.
bool is_number_or_version(const std::string& extension) {
  const std::string_view digits =
      std::string_view(extension).substr(extension.starts_with(".v") ? 2 : 1);
  return !digits.empty() &&
         std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_known_format(const std::string& extension) {
  return extension == kExr || extension == kPfm || extension == kPng || is_radiance(extension) ||
         traits_of(extension);
}

void write_by_openimageio(const std::string& path, const Image& image,
                          const ImageMetadata& metadata, float exposure) {
  const std::string extension = lower_extension(path);
  const auto traits = traits_of(extension);
  const OpenImageIo& library = open_image_io();
  if (!traits) {
    throw Error(fmt::format("cannot write '{}': {}", path,
                            library.failure.empty() ? "unknown format" : library.failure));
  }
  check_image_size(path, image.width, image.height);
  openimageio::Pixels pixels{image.width, image.height, {}, nullptr, nullptr, metadata};
  std::vector<uint8_t> bytes;
  if (traits->is_linear) {
    pixels.channels = image.channels;
    pixels.floats = image.data.data();
  } else {
    const bool stores_grey = is_grey(extension);
    const SrgbBytes srgb = srgb_bytes_of(stores_grey ? luminance_of(image) : image, exposure,
                                         traits->has_alpha && !stores_grey);
    // Several formats don't support images of one channel: grey becomes R, G, B.
    const size_t colors = stores_grey ? 1 : 3;
    pixels.channels = stores_grey ? std::vector<std::string>{"Y"}
                                  : std::vector<std::string>{"R", "G", "B"};
    if (srgb.has_alpha) pixels.channels.emplace_back("A");
    const size_t stride = static_cast<size_t>(srgb.colors) + (srgb.has_alpha ? 1 : 0);
    for (size_t i = 0; i < srgb.bytes.size(); i += stride) {
      for (size_t c = 0; c < colors; ++c) bytes.push_back(srgb.bytes[i + (srgb.colors == 3 ? c : 0)]);
      if (srgb.has_alpha) bytes.push_back(srgb.bytes[i + stride - 1]);
    }
    pixels.bytes = bytes.data();
  }
  // OpenImageIO writes to a temporary file, so that `path` is either complete or unchanged.
  const ScratchFolder scratch(path);
  const std::string file = scratch.file("image" + extension);
  std::string failure;
  if (!library.write || !library.write(file.c_str(), pixels, failure)) {
    throw Error(fmt::format("cannot write '{}': {}", path, failure));
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw Error(fmt::format("cannot write '{}': the disk may be full", path));
  write_text(path, text.str());
}

}  // namespace

std::string image_path(const std::string& output, const std::string& film_extension) {
  const std::string given = lower_extension(output);
  std::error_code failed;
  if (given == film_extension || fs::is_other(output, failed)) return output;
  if (given.empty() || is_number_or_version(given)) return output + film_extension;
  if (is_known_format(given)) return output;
  const std::string& failure = open_image_io().failure;
  const std::string own = film_extension == kExr ? "" : film_extension + ", ";
  throw Error(fmt::format("-o {}: unknown image format '{}': use {}.exr, .pfm, .hdr or .png{}",
                          output, given, own,
                          failure.empty() ? ", or another format that OpenImageIO writes, such as "
                                            ".tif, .jpg, .webp, .tga or .bmp"
                                          : " (OpenImageIO isn't available: " + failure + ")"));
}

void check_image_size(const std::string& path, int width, int height) {
  const std::string extension = lower_extension(path);
  // Kinome's own formats have no limits.
  const bool is_own = extension.empty() || extension == kExr || extension == kPfm ||
                      extension == kPng || is_radiance(extension);
  const auto traits = is_own ? std::nullopt : traits_of(extension);
  if (!traits || traits->limits.contain(width, height)) return;
  throw Error(fmt::format("-o {}: {} files must have {}, got {}x{}", path, extension,
                          traits->limits.text(), width, height));
}

bool stores_channels(const std::string& extension, const Film* film) {
  if (extension == kExr) return true;
  if (extension == kPfm || extension == kPng || is_radiance(extension)) return false;
  if (extension.empty() || (film && extension == film->file_extension())) return true;
  const auto traits = traits_of(extension);
  return traits && traits->is_linear;
}

bool stores_srgb(const std::string& extension, const Film* film) {
  if (extension == kPng) return true;
  const bool is_of_film = extension.empty() || (film && extension == film->file_extension());
  if (is_of_film || extension == kExr || extension == kPfm || is_radiance(extension)) return false;
  const auto traits = traits_of(extension);
  return traits && !traits->is_linear;
}

void warn_of_lost_channels(const Image& image, const std::string& path, const Film* film) {
  constexpr std::string_view kColor[] = {"R", "G", "B", "Y", "A"};
  const std::string extension = lower_extension(path);
  const bool has_others = std::ranges::any_of(image.channels, [&](const std::string& channel) {
    return std::ranges::find(kColor, channel) == std::end(kColor);
  });
  if (!has_others || stores_channels(extension, film)) return;
  log_warn(
      fmt::format("{} files store only colour: the image's other channels are left out", extension));
}

void write_image(const std::string& path, const Film* film, const Image& image,
                 const ImageMetadata& metadata, float exposure) {
  const std::string extension = lower_extension(path);
  if (film && (extension.empty() || extension == film->file_extension())) {
    film->write(path, image, metadata);
  } else if (film && extension == kExr) {
    const Rect& crop = film->crop();
    write_exr(path, image, ExrSampleType::kFloat, metadata, Vec2(crop.x0, crop.y0),
              Vec2(film->width(), film->height()));
  } else if (extension.empty() || extension == kExr) {
    write_exr(path, image, ExrSampleType::kFloat, metadata);
  } else if (extension == kPfm) {
    write_pfm(path, image);
  } else if (is_radiance(extension)) {
    write_rgbe(path, image);
  } else if (extension == kPng) {
    write_png(path, image, exposure);
  } else {
    write_by_openimageio(path, image, metadata, exposure);
  }
}

}  // namespace kinome::app

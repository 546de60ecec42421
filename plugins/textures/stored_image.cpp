#include "stored_image.h"

#include <dlfcn.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#include "kinome/image_files.h"
#include "kinome/image.h"
#include "kinome/instruction_set.h"
#include "kinome/log.h"
#include "kinome/read_files.h"

namespace kinome {
namespace {

/// Returns R, G and B, or a single channel, of a float image.
StoredImage pick_channels(const Image& image, const Location& source) {
  std::vector<int> picked{image.find_channel("R"), image.find_channel("G"),
                          image.find_channel("B")};
  if (picked[0] < 0 || picked[1] < 0 || picked[2] < 0) {
    const int grey = image.channel_count() == 1 ? 0 : image.find_channel("Y");
    if (grey < 0) {
      std::string names;
      for (const std::string& name : image.channels) names += (names.empty() ? "" : ", ") + name;
      throw Error(source, "has no colour: it has the channels " + names +
                              ", expected R, G, B, or X, Y, Z, or Y, or a single one");
    }
    picked = {grey};
  }
  StoredImage stored;
  for (int c = 0; c < image.channel_count(); ++c) {
    const bool is_picked = std::find(picked.begin(), picked.end(), c) != picked.end();
    if (!is_picked) stored.unused.push_back("channel " + image.channels[static_cast<size_t>(c)]);
  }
  stored.width = image.width;
  stored.height = image.height;
  stored.channels = static_cast<int>(picked.size());
  stored.floats.reserve(static_cast<size_t>(image.width) * image.height * picked.size());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (const int c : picked) {
        stored.floats.push_back(image.at(x, y, c));
      }
    }
  }
  return stored;
}

/// Returns the folder of the plugin that contains this code, without the subfolder of an
/// instruction set.
std::filesystem::path plugin_folder() {
  Dl_info info{};
  static const char anchor = 0;
  dladdr(&anchor, &info);
  const auto folder = std::filesystem::path(info.dli_fname ? info.dli_fname : "").parent_path();
  return instruction_set_named(folder.filename().string()) ? folder.parent_path() : folder;
}

ReadImageFunction open_reader(const char* name, const Properties& props) {
  const std::string library = (plugin_folder() / name).lexically_normal().string();
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = handle ? dlsym(handle, kReadImageSymbol) : nullptr;
  if (!symbol) {
    const char* const reason = dlerror();
    throw props.error("filename", std::string("requires a library that can't be loaded: ") +
                                      (reason ? reason : library));
  }
  return reinterpret_cast<ReadImageFunction>(symbol);
}

StoredImage read_file(const std::string& path, const Properties& props) {
  std::string magic(4, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Location{path}, std::string("can't be read: ") + std::strerror(errno));
  file.read(magic.data(), 4);
  if (magic == "\x76\x2f\x31\x01") return pick_channels(read_exr(path), Location{path});
  if (magic.starts_with("PF") || magic.starts_with("Pf")) {
    return pick_channels(read_pfm(path), Location{path});
  }
  const std::string bytes = file_contents(path);
  StoredImage image;
  std::string error;
  for (const char* library : kReadImageLibraries) {
    if (open_reader(library, props)(path.c_str(), bytes, image, error)) return image;
    if (!error.empty()) break;
  }
  throw Error(Location{path}, "can't be read as an image: " + error);
}

std::string texels(size_t count) {
  return std::to_string(count) + (count == 1 ? " texel" : " texels");
}

/// Warns at the file and not at its use, so that the warning appears once per scene: equal texts
/// are suppressed.
void warn_at(const Location& source, const std::string& message) {
  log_warn(Error(source, message).what());
}

void replace_nonfinite_values(std::vector<float>& values, size_t channels, const Location& source) {
  float max_abs = 65504;
  for (const float v : values) {
    if (std::isfinite(v)) max_abs = std::max(max_abs, std::abs(v));
  }
  size_t nans = 0, infinities = 0;
  for (size_t i = 0; i < values.size(); i += channels) {
    bool has_nan = false, is_infinite = false;
    for (size_t c = i; c < i + channels; ++c) {
      if (std::isfinite(values[c])) continue;
      has_nan |= std::isnan(values[c]);
      is_infinite |= std::isinf(values[c]);
      values[c] = std::isnan(values[c]) ? 0 : std::copysign(max_abs, values[c]);
    }
    nans += has_nan;
    infinities += is_infinite;
  }
  if (nans > 0) warn_at(source, texels(nans) + " with NaN, which becomes 0");
  if (infinities > 0) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", double{max_abs});  // may exceed integer types
    warn_at(source, texels(infinities) + " with infinity, which becomes " + text);
  }
}

/// Warns about negative values if their sum matters: photographs of the sky often have a few values
/// just below 0, from filtering or compression.
void warn_of_negative_values(const std::vector<float>& values, size_t channels,
                             const Location& source) {
  constexpr double kMinShare = 1e-3;
  double below = 0, sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < values.size(); i += channels) {
    bool is_negative = false;
    for (size_t c = i; c < i + channels; ++c) {
      is_negative |= values[c] < 0;
      below += std::max(0.f, -values[c]);
      sum += std::abs(values[c]);
    }
    count += is_negative;
  }
  if (!(below > kMinShare * sum)) return;
  char percent[32];
  std::snprintf(percent, sizeof percent, "%.2g", 100 * below / sum);
  warn_at(source, texels(count) + (count == 1 ? " is" : " are") + " negative, with " + percent +
                      " % of the image's energy, and " + (count == 1 ? "is kept" : "are kept"));
}

}  // namespace

LoadedImage::LoadedImage(const Properties& props) {
  props.exclude("data", "filename");
  if (const auto pixels = props.image("data")) {
    source = props.error("data", "").where();
    image = pick_channels(*pixels, source);
  } else {
    source = Location{props.file("filename"), 0, 0};
    try {
      image = read_file(source.file, props);
    } catch (const std::bad_alloc&) {
      throw Error(source, "doesn't fit in memory");
    }
  }
  log_unused(source.file, image.unused);
  const auto channels = static_cast<size_t>(image.channels);
  replace_nonfinite_values(image.floats, channels, source);
  warn_of_negative_values(image.floats, channels, source);
}

}  // namespace kinome

// Reads and writes OpenEXR files.

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfRgbaFile.h>
#include <ImfStringAttribute.h>
#include <OpenEXRConfig.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <half.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "image_files/color_channels.h"
#include "image_files/exr_colors.h"
#include "image_files/exr_files.h"
#include "image_files/image_exr_check.h"
#include "kinome/image_files.h"
#include "kinome/log.h"

namespace kinome {
namespace {

constexpr float kLargestHalf = 65504;

/// Returns the colour channels, then the others in the file's (alphabetical) order.
std::vector<std::string> ordered_channels(const Imf::ChannelList& list, const ExrColor& color) {
  std::vector<std::string> names = color.channels;
  for (auto it = list.begin(); it != list.end(); ++it) {
    const bool is_color =
        std::find(color.channels.begin(), color.channels.end(), it.name()) != color.channels.end();
    if (!is_color) names.emplace_back(it.name());
  }
  return names;
}

/// Returns slices of interleaved floats whose first pixel is the data window's corner.
Imf::FrameBuffer float_slices(Image& image, const Imath::Box2i& window) {
  Imf::FrameBuffer buffer;
  const size_t pixel_bytes = image.channels.size() * sizeof(float);
  for (size_t c = 0; c < image.channels.size(); ++c) {
    buffer.insert(image.channels[c],
                  Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, window, pixel_bytes,
                                   pixel_bytes * static_cast<size_t>(image.width)));
  }
  return buffer;
}

/// The EXR part with the best colour (see ExrColorKind). The constructor throws std::runtime_error
/// if the file has several parts and none has a colour.
struct ChosenPart {
  explicit ChosenPart(const std::string& path, const Imf::MultiPartInputFile& file) {
    std::vector<std::string> others;
    for (int i = 0; i < file.parts(); ++i) {
      ExrColor found = find_exr_color(file.header(i).channels());
      if (i > 0 && found.kind >= color.kind) continue;
      index = i;
      color = std::move(found);
    }
    if (file.parts() > 1 && color.kind == ExrColorKind::kNone) {
      throw std::runtime_error(fmt::format(
          "none of its {} parts has a colour: channels R, G, B, or X, Y, Z, or Y", file.parts()));
    }
    for (int i = 0; i < file.parts(); ++i) {
      const Imf::Header& header = file.header(i);
      if (i != index) others.push_back("part " + (header.hasName() ? header.name() : ""));
    }
    log_unused(path, others);
    if (!color.other_layers.empty()) {
      log_warn(fmt::format("'{}' has several layers with colour: using '{}', ignoring {}", path,
                           color.channels[0], fmt::join(color.other_layers, ", ")));
    }
  }
  int index = 0;
  ExrColor color;
};

/// Reads a file with luminance and subsampled chroma, which OpenEXR converts in half precision.
void read_luminance_chroma(const std::string& path, int part, const Imath::Box2i& window,
                           const ExrColor& color, Image& image) {
  if (part != 0) {
    throw std::runtime_error("luminance and chroma are supported only in a file's first part");
  }
  Imf::RgbaInputFile file(path.c_str());
  Imf::Array2D<Imf::Rgba> pixels(image.height, image.width);
  // The address of pixel (0, 0), which may be outside the window.
  file.setFrameBuffer(&pixels[0][0] - window.min.x - ptrdiff_t{window.min.y} * image.width, 1,
                      static_cast<size_t>(image.width));
  file.readPixels(window.min.y, window.max.y);
  image.channels = color.names;
  image.data.reserve(static_cast<size_t>(image.width) * image.height * image.channels.size());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Imf::Rgba& p = pixels[y][x];
      image.data.insert(image.data.end(), {p.r, p.g, p.b});
      if (image.channels.size() == 4) image.data.push_back(p.a);
    }
  }
}

/// Returns the position of a file's pixels in its display window.
ExrWindow window_of(const Imf::Header& header) {
  const Imath::Box2i &pixels = header.dataWindow(), &all = header.displayWindow();
  const Imath::V2i offset = pixels.min - all.min, size = all.max - all.min + Imath::V2i(1);
  return {Vec2(offset.x, offset.y), Vec2(size.x, size.y)};
}

Image read_checked(const std::string& path, ImageMetadata* metadata, ExrWindow* exr_window) {
  check_exr(path);
  use_threads_for(std::filesystem::file_size(path));
  Imf::MultiPartInputFile file(path.c_str());
  const ChosenPart chosen(path, file);
  const ExrColor& color = chosen.color;
  const Imf::Header& header = file.header(chosen.index);
  const Imath::Box2i& window = header.dataWindow();
  Image image;
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;
  if (color.kind == ExrColorKind::kLuminanceChroma) {
    read_luminance_chroma(path, chosen.index, window, color, image);
  } else {
    image.channels = ordered_channels(header.channels(), color);
    image.data.resize(static_cast<size_t>(image.width) * image.height * image.channels.size());
    Imf::InputPart part(file, chosen.index);
    part.setFrameBuffer(float_slices(image, window));
    part.readPixels(window.min.y, window.max.y);
    std::copy(color.names.begin(), color.names.end(), image.channels.begin());
  }
  convert_to_rec709(header, color.kind, image);
  if (metadata) read_metadata(header, *metadata);
  if (exr_window) *exr_window = window_of(header);
  return image;
}

void check_image(const std::string& path, const Image& image) {
  check_not_empty(path, image);
  std::set<std::string> names;
  for (const std::string& name : image.channels) {
    if (!names.insert(name).second) {
      throw Error(fmt::format("cannot write '{}': two channels are named '{}'", path, name));
    }
  }
}

constexpr Imf::PixelType kPixelTypes[] = {Imf::HALF, Imf::FLOAT, Imf::UINT};  // by ExrSampleType

Imf::Header make_header(const Image& image, ExrSampleType number, const ImageMetadata& metadata,
                        Vec2 crop_offset, Vec2 full_size) {
  if (full_size == Vec2(0.f)) full_size = Vec2(image.width, image.height);
  const Imath::V2i first(static_cast<int>(crop_offset.x), static_cast<int>(crop_offset.y));
  const Imath::V2i last = first + Imath::V2i(image.width - 1, image.height - 1);
  const Imath::Box2i display(Imath::V2i(0), Imath::V2i(static_cast<int>(full_size.x) - 1,
                                                       static_cast<int>(full_size.y) - 1));
  Imf::Header header(display, Imath::Box2i(first, last));
  // PIZ compresses many noisy halves fastest. Up to about 320x240 pixels, ZIP takes half as long or
  // less, because PIZ initializes tables for each 32 rows. For floats, ZIP is as small and much
  // faster at any size.
  constexpr size_t kMinValuesForPiz = 1 << 18;
  const bool is_for_piz = number == ExrSampleType::kHalf && image.data.size() >= kMinValuesForPiz;
  header.compression() = is_for_piz ? Imf::PIZ_COMPRESSION : Imf::ZIP_COMPRESSION;
#if OPENEXR_VERSION_MAJOR * 10000 + OPENEXR_VERSION_MINOR * 100 + OPENEXR_VERSION_PATCH >= 30103
  // Noise compresses no better at OpenEXR's level, 4, which takes 7 to 15 % longer.
  header.zipCompressionLevel() = 2;
#endif
  for (const std::string& name : image.channels) {
    header.channels().insert(name, Imf::Channel(kPixelTypes[static_cast<int>(number)]));
  }
  for (const auto& [name, value] : metadata) header.insert(name, Imf::StringAttribute(value));
  return header;
}

/// Converts to halves. Clamps finite values to the largest half, with one warning, because a value
/// written as infinity would spread to everything that is computed from the file.
std::vector<half> to_halves(const std::string& path, const Image& image) {
  std::vector<half> halves(image.data.size());
  size_t clamped = 0;
  for (size_t i = 0; i < halves.size(); ++i) {
    float v = image.data[i];
    if (std::abs(v) > kLargestHalf && std::isfinite(v)) {
      v = std::copysign(kLargestHalf, v);
      ++clamped;
    }
    halves[i] = half(v);
  }
  if (clamped > 0) {
    log_warn(fmt::format(
        "'{}': {} clamped to {}, the largest value of float16; to keep {}, set component_format to "
        "float32",
        path, clamped == 1 ? "1 value was" : fmt::format("{} values were", clamped), kLargestHalf,
        clamped == 1 ? "it" : "them"));
  }
  return halves;
}

std::vector<uint32_t> to_integers(const Image& image) {
  std::vector<uint32_t> integers(image.data.size());
  constexpr double kLargest = 0xffffffffu;
  for (size_t i = 0; i < integers.size(); ++i) {
    const double v = image.data[i] > 0 ? std::min<double>(image.data[i], 1) : 0;  // 0 for NaN
    integers[i] = static_cast<uint32_t>(std::lround(v * kLargest));
  }
  return integers;
}

}  // namespace

Image read_exr(const std::string& path, const Location& requester, ImageMetadata* metadata,
               ExrWindow* window) {
  const auto fail = [&](const std::string& why) {
    const Error error(Location{path}, "can't be read: " + why);
    return requester.file.empty() ? error : error.requested_by(requester);
  };
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw fail(std::filesystem::exists(path, ignored) ? "it is not a file" : "no such file");
  }
  try {
    return read_checked(path, metadata, window);
  } catch (const std::exception& e) {
    throw fail(why_unreadable(e));
  }
}

void write_exr(const std::string& path, const Image& image, ExrSampleType number,
               const ImageMetadata& metadata, Vec2 crop_offset, Vec2 full_size) {
  check_image(path, image);
  use_threads_for(image.data.size() * sizeof(float));
  write_by_openexr(path, [&](Imf::OStream& stream) {
    const Imf::Header header = make_header(image, number, metadata, crop_offset, full_size);
    Imf::OutputFile file(stream, header);
    const Imath::Box2i& window = header.dataWindow();
    Imf::FrameBuffer buffer;
    std::vector<half> halves;
    std::vector<uint32_t> integers;
    size_t bytes = sizeof(float);
    auto* base = reinterpret_cast<const char*>(image.data.data());
    if (number == ExrSampleType::kHalf) {
      halves = to_halves(path, image);
      bytes = sizeof(half);
      base = reinterpret_cast<const char*>(halves.data());
    } else if (number == ExrSampleType::kUint) {
      integers = to_integers(image);
      base = reinterpret_cast<const char*>(integers.data());
    }
    const size_t stride = image.channels.size() * bytes;
    for (size_t c = 0; c < image.channels.size(); ++c) {
      buffer.insert(image.channels[c],
                    Imf::Slice::Make(kPixelTypes[static_cast<int>(number)], base + c * bytes,
                                     window, stride, stride * static_cast<size_t>(image.width)));
    }
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  });
}

}  // namespace kinome

// OpenEXR files, read and written.

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <half.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "image/exr_files.h"
#include "image/image_exr_check.h"
#include "kinome/image.h"
#include "kinome/log.h"

namespace kinome {
namespace {

constexpr float kLargestHalf = 65504;

/// R, G, B, A first, the others in the file's (alphabetic) order.
std::vector<std::string> ordered_channels(const Imf::ChannelList& list) {
  std::vector<std::string> names;
  for (const char* name : {"R", "G", "B", "A"}) {
    if (list.findChannel(name)) names.emplace_back(name);
  }
  const size_t colors = names.size();
  for (auto it = list.begin(); it != list.end(); ++it) {
    const std::string name = it.name();
    if (std::find(names.begin(), names.begin() + static_cast<long>(colors), name) ==
        names.begin() + static_cast<long>(colors)) {
      names.push_back(name);
    }
  }
  return names;
}

/// Slices of interleaved floats whose first pixel is the data window's corner.
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

/// Of two sets of primaries and white: by so little they may differ and still be meant to be the
/// same (Mitsuba 3's measure: such files keep their values there as well).
bool are_same(const Imf::Chromaticities& a, const Imf::Chromaticities& b) {
  constexpr float kSquaredDistance = 1e-6f;
  return (a.red - b.red).length2() + (a.green - b.green).length2() + (a.blue - b.blue).length2() +
             (a.white - b.white).length2() <
         kSquaredDistance;
}

/// From the file's colours to linear Rec.709 (OpenEXR multiplies rows by it). Both whites have
/// Y = 1 and keep their colour: no adaptation. Throws a text for primaries that span no colours.
Imath::M44f matrix_to_rec709(const Imf::Chromaticities& file) {
  // Of colour spaces in use, values stay within [-0.1, 1.1], and areas are 0.1 (as Rec.709's) or
  // more. Within these limits, floats tell a triangle from a line.
  constexpr float kMost = 10;
  constexpr float kLeast = 1e-4f;
  bool is_usable = true;
  for (const Imath::V2f& v : {file.red, file.green, file.blue, file.white}) {
    is_usable = is_usable && std::abs(v.x) <= kMost && std::abs(v.y) <= kMost;
  }
  const float twice_area = (file.green - file.red).cross(file.blue - file.red);
  if (!is_usable || !(std::abs(twice_area) >= kLeast) || !(std::abs(file.white.y) >= kLeast)) {
    throw std::runtime_error(fmt::format(
        "its attribute 'chromaticities' describes no colours: red ({}, {}), green ({}, {}), blue "
        "({}, {}), white ({}, {}); the primaries must span a triangle, and white's y not be 0",
        file.red.x, file.red.y, file.green.x, file.green.y, file.blue.x, file.blue.y, file.white.x,
        file.white.y));
  }
  return Imf::RGBtoXYZ(file, 1) * Imf::XYZtoRGB(Imf::Chromaticities(), 1);
}

/// Colours of other primaries than Rec.709's become linear Rec.709. R, G, B only: further layers
/// may be anything but colours.
void convert_to_rec709(const Imf::Header& header, Image& image) {
  const bool is_rgb = image.channels.size() >= 3 && image.channels[0] == "R" &&
                      image.channels[1] == "G" && image.channels[2] == "B";
  if (!is_rgb || !Imf::hasChromaticities(header)) return;
  const Imf::Chromaticities& file = Imf::chromaticities(header);
  if (are_same(file, Imf::Chromaticities())) return;
  const Imath::M44f matrix = matrix_to_rec709(file);
  for (size_t i = 0; i < image.data.size(); i += image.channels.size()) {
    float* const pixel = &image.data[i];
    const Imath::V3f color(pixel[0], pixel[1], pixel[2]);
    for (int c = 0; c < 3; ++c) {
      pixel[c] = color.x * matrix[0][c] + color.y * matrix[1][c] + color.z * matrix[2][c];
    }
  }
}

Image read_checked(const std::string& path, ImageMetadata* metadata) {
  check_exr(path);
  Imf::InputFile file(path.c_str());
  const Imf::Header& header = file.header();
  const Imath::Box2i& window = header.dataWindow();
  Image image;
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;
  image.channels = ordered_channels(header.channels());
  image.data.resize(static_cast<size_t>(image.width) * image.height * image.channels.size());
  file.setFrameBuffer(float_slices(image, window));
  file.readPixels(window.min.y, window.max.y);
  convert_to_rec709(header, image);
  if (metadata) read_metadata(header, *metadata);
  return image;
}

void check_image(const std::string& path, const Image& image) {
  const size_t values = static_cast<size_t>(image.width) * image.height * image.channels.size();
  if (image.width < 1 || image.height < 1 || image.channels.empty() ||
      image.data.size() != values) {
    throw Error(fmt::format("cannot write '{}': the picture is empty", path));
  }
  std::set<std::string> names;
  for (const std::string& name : image.channels) {
    if (!names.insert(name).second) {
      throw Error(fmt::format("cannot write '{}': two channels are named '{}'", path, name));
    }
  }
}

constexpr Imf::PixelType kPixelTypes[] = {Imf::HALF, Imf::FLOAT, Imf::UINT};  // by ExrNumber

Imf::Header make_header(const Image& image, ExrNumber number, const ImageMetadata& metadata,
                        Vec2 crop_offset, Vec2 full_size) {
  if (full_size == Vec2(0.f)) full_size = Vec2(image.width, image.height);
  const Imath::V2i first(static_cast<int>(crop_offset.x), static_cast<int>(crop_offset.y));
  const Imath::V2i last = first + Imath::V2i(image.width - 1, image.height - 1);
  const Imath::Box2i display(Imath::V2i(0), Imath::V2i(static_cast<int>(full_size.x) - 1,
                                                       static_cast<int>(full_size.y) - 1));
  Imf::Header header(display, Imath::Box2i(first, last));
  // Wavelets suit noisy halves; for floats ZIP is as small, and much faster.
  header.compression() =
      number == ExrNumber::kHalf ? Imf::PIZ_COMPRESSION : Imf::ZIP_COMPRESSION;
  for (const std::string& name : image.channels) {
    header.channels().insert(name, Imf::Channel(kPixelTypes[static_cast<int>(number)]));
  }
  for (const auto& [name, value] : metadata) header.insert(name, Imf::StringAttribute(value));
  return header;
}

/// Finite values that a half can't hold become its largest one, with one warning: a sun written as
/// Inf would poison everything that is computed from the file.
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
        "'{}': {} beyond {} clamped to it, the largest that float16 holds; component_format "
        "float32 keeps {}",
        path, clamped == 1 ? "1 value" : fmt::format("{} values", clamped),
        fmt::format("{} {}", kLargestHalf, clamped == 1 ? "was" : "were"),
        clamped == 1 ? "it" : "them"));
  }
  return halves;
}

std::vector<uint32_t> to_integers(const Image& image) {
  std::vector<uint32_t> integers(image.data.size());
  constexpr double kLargest = 0xffffffffu;
  for (size_t i = 0; i < integers.size(); ++i) {
    const double v = image.data[i] > 0 ? std::min<double>(image.data[i], 1) : 0;  // of a NaN, too
    integers[i] = static_cast<uint32_t>(std::lround(v * kLargest));
  }
  return integers;
}

}  // namespace

Image read_exr(const std::string& path, const Location& asker, ImageMetadata* metadata) {
  const auto fail = [&](const std::string& why) {
    const Error error(Location{path}, "can't be read: " + why);
    return asker.file.empty() ? error : error.asked_for_by(asker);
  };
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw fail(std::filesystem::exists(path, ignored) ? "it is not a file" : "no such file");
  }
  try {
    return read_checked(path, metadata);
  } catch (const std::exception& e) {
    throw fail(why_unreadable(e));
  }
}

void write_exr(const std::string& path, const Image& image, ExrNumber number,
               const ImageMetadata& metadata, Vec2 crop_offset, Vec2 full_size) {
  check_image(path, image);
  write_by_openexr(path, [&](Imf::OStream& stream) {
    const Imf::Header header = make_header(image, number, metadata, crop_offset, full_size);
    Imf::OutputFile file(stream, header);
    const Imath::Box2i& window = header.dataWindow();
    Imf::FrameBuffer buffer;
    std::vector<half> halves;
    std::vector<uint32_t> integers;
    size_t bytes = sizeof(float);
    auto* base = reinterpret_cast<const char*>(image.data.data());
    if (number == ExrNumber::kHalf) {
      halves = to_halves(path, image);
      bytes = sizeof(half);
      base = reinterpret_cast<const char*>(halves.data());
    } else if (number == ExrNumber::kUint) {
      integers = to_integers(image);
      base = reinterpret_cast<const char*>(integers.data());
    }
    const size_t stride = image.channels.size() * bytes;
    for (size_t c = 0; c < image.channels.size(); ++c) {
      buffer.insert(image.channels[c],
                    Imf::Slice::Make(kPixelTypes[static_cast<int>(number)], base + c * bytes, window,
                                     stride, stride * static_cast<size_t>(image.width)));
    }
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  });
}

}  // namespace kinome

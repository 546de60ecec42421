#include "image_reader.h"

#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "kinome/export.h"

namespace {

using kinome::StoredImage;

/// Throws where a header promises what the file can't hold, `bytes` being all pixels: before
/// anything is allocated.
void check_size(int64_t width, int64_t height, uint64_t bytes, uint64_t file_size) {
  constexpr int64_t kMaxSide = 1 << 17;
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw std::runtime_error("its header gives an absurd size, " + size);
  }
  // Deflate reaches 1032 : 1; a flat JPEG stays below that.
  constexpr uint64_t kBestRatio = 2000;
  if (bytes / kBestRatio > file_size) {
    throw std::runtime_error("truncated: " + std::to_string(file_size) + " bytes can't hold " +
                             size + " pixels");
  }
}

/// A truncated JPEG decodes to grey without complaint; but then its last scan has no end marker.
/// (Inside a scan neither marker can occur; thumbnails lie before it.)
bool lacks_jpeg_end(const std::string& bytes) {
  if (bytes.rfind("\xff\xd8", 0) != 0) return false;
  const size_t scan = bytes.rfind("\xff\xda");
  return scan == std::string::npos || bytes.find("\xff\xd9", scan) == std::string::npos;
}

uint32_t big_endian(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// Of a damaged PNG, and of one that claims to be huge, libpng complains on stderr by itself,
/// beside our own error: so what commonly damages files is looked for before. (PNG Specification,
/// second edition, 5.3: length, type, data, checksum of the type and the data.)
void check_png(const std::string& bytes) {
  constexpr size_t kSignature = 8, kAround = 12;
  if (bytes.rfind("\x89PNG", 0) != 0) return;
  bool has_palette = false, needs_palette = false;
  std::string type;
  for (size_t at = kSignature; type != "IEND";) {
    const size_t left = bytes.size() - std::min(at, bytes.size());
    const size_t length = left < kAround ? left : big_endian(bytes, at);
    if (left < kAround || length > left - kAround) {
      throw std::runtime_error("truncated: it ends within the picture");
    }
    type = bytes.substr(at + 4, 4);
    const auto* const begin = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    const size_t checked = length + 4;
    // Of what isn't critical (5.4), a small letter first, readers do without; transparency counts
    // as what is seen.
    const bool is_critical = (type[0] & 0x20) == 0 || type == "tRNS";
    if (is_critical && crc32_z(0, begin, checked) != big_endian(bytes, at + 4 + checked)) {
      throw std::runtime_error("damaged: the checksum of a part of it is wrong");
    }
    if (type == "IHDR" && length == 13) {
      constexpr char kPalette = 3;
      needs_palette = bytes[at + 17] == kPalette;
      const uint64_t width = big_endian(bytes, at + 8), height = big_endian(bytes, at + 12);
      // A pixel may be a single bit.
      check_size(static_cast<int64_t>(width), static_cast<int64_t>(height), width * height / 8,
                 bytes.size());
    }
    has_palette |= type == "PLTE";
    if (type == "IDAT" && needs_palette && !has_palette) {
      throw std::runtime_error("damaged: it has no palette");
    }
    at += length + kAround;
  }
}

/// Before OpenImageIO sees the file: libpng's long jumps past its frames leak memory.
void check_bytes(const char* path) {
  std::string bytes(std::filesystem::file_size(path), '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<long>(bytes.size()));
  if (lacks_jpeg_end(bytes)) throw std::runtime_error("truncated: it ends within the picture");
  check_png(bytes);
}

template <class T>
void read_pixels(OIIO::ImageInput& input, const StoredImage& image, std::vector<T>& pixels,
                 OIIO::TypeDesc type) {
  pixels.resize(static_cast<size_t>(image.width) * image.height * image.channels);
  if (!input.read_image(0, 0, 0, image.channels, type, pixels.data())) {
    throw std::runtime_error(input.geterror());
  }
}

void read(const char* path, StoredImage& image) {
  check_bytes(path);
  OIIO::attribute("threads", 1);
  // Colours as stored, not multiplied by alpha.
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    throw std::runtime_error(OIIO::geterror());
  }
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.nchannels < 1) throw std::runtime_error("it has no channels");
  check_size(spec.width, spec.height, static_cast<uint64_t>(spec.image_bytes(true)),
             std::filesystem::file_size(path));
  image.width = spec.width;
  image.height = spec.height;
  image.channels = spec.nchannels >= 3 ? 3 : 1;
  image.is_encoded = !spec.format.is_floating_point();
  for (int c = image.channels; c < spec.nchannels; ++c) {
    image.unused.push_back("channel " + std::string(spec.channel_name(c)));
  }
  if (spec.format == OIIO::TypeDesc::UINT8) {
    read_pixels(*input, image, image.bytes, OIIO::TypeDesc::UINT8);
  } else {
    read_pixels(*input, image, image.floats, OIIO::TypeDesc::FLOAT);
  }
}

}  // namespace

extern "C" KINOME_EXPORT bool kinome_read_image(const char* path, StoredImage& image,
                                                std::string& error) {
  try {
    read(path, image);
    return true;
  } catch (const std::exception& e) {
    const std::string message = e.what();
    error = message.substr(0, message.find('\n'));
    return false;
  }
}

#include "image_reader.h"

#include <OpenImageIO/imageio.h>

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

/// Of a truncated PNG, libpng complains on stderr by itself, beside our own error.
bool lacks_png_end(const std::string& bytes) {
  return bytes.rfind("\x89PNG", 0) == 0 && bytes.rfind("IEND") == std::string::npos;
}

/// Of a PNG that claims to be huge, libpng complains, too. A pixel may be a single bit.
void check_png_size(const std::string& bytes) {
  if (bytes.rfind("\x89PNG", 0) != 0 || bytes.size() < 24) return;
  const auto number = [&](size_t at) {
    int64_t value = 0;
    for (size_t i = at; i < at + 4; ++i) {
      value = value * 256 + static_cast<unsigned char>(bytes[i]);
    }
    return value;
  };
  const int64_t width = number(16), height = number(20);
  check_size(width, height, static_cast<uint64_t>(width) * static_cast<uint64_t>(height) / 8,
             bytes.size());
}

/// Before OpenImageIO sees the file: libpng's long jumps past its frames leak memory.
void check_bytes(const char* path) {
  std::string bytes(std::filesystem::file_size(path), '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<long>(bytes.size()));
  if (lacks_jpeg_end(bytes) || lacks_png_end(bytes)) {
    throw std::runtime_error("truncated: it ends within the picture");
  }
  check_png_size(bytes);
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

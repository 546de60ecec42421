#include <OpenImageIO/imageio.h>

#include "image_formats.h"
#include "kinome/export.h"

namespace {

using kinome::StoredImage;

template <class T>
void read_pixels(OIIO::ImageInput& input, const StoredImage& image, std::vector<T>& pixels,
                 OIIO::TypeDesc type) {
  pixels.resize(static_cast<size_t>(image.width) * image.height * image.channels);
  if (!input.read_image(0, 0, 0, image.channels, type, pixels.data())) {
    throw std::runtime_error(input.geterror());
  }
}

void read(const char* path, uint64_t file_size, StoredImage& image) {
  OIIO::attribute("threads", 1);
  // Colours as stored, without multiplication by alpha.
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    throw std::runtime_error(OIIO::geterror());
  }
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.nchannels < 1) throw std::runtime_error("it has no channels");
  // An image of a single colour may need only a few bytes for any size, so images up to 256 MB
  // pass.
  constexpr uint64_t kSmall = uint64_t{1} << 28, kBestRatio = 2000;
  const auto unpacked = static_cast<uint64_t>(spec.image_bytes(true));
  kinome::set_size(image, spec.width, spec.height, unpacked > kSmall ? unpacked : 0, kBestRatio,
                   file_size);
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

extern "C" KINOME_EXPORT bool kinome_read_image(const char* path, const std::string& bytes,
                                                StoredImage& image, std::string& error) {
  return kinome::report_errors(error, [&] {
    read(path, bytes.size(), image);
    return true;
  });
}

#include "image_files/openimageio/openimageio_writer.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <stdexcept>
#include <string>

#include "image_files/openimageio/varying_bytes.h"
#include "kinome/export.h"

namespace {

using kinome::openimageio::Pixels;
using kinome::openimageio::WriterTraits;

/// Names of OpenImageIO's formats that store floats and any number of channels.
constexpr const char* kLinearFormats[] = {"tiff", "fits"};
/// Names of formats that don't store colour images in a file, or that Kinome writes by itself.
constexpr const char* kOtherFormats[] = {"null", "term", "zfile", "openexr"};

bool has(const auto& names, const std::string& name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

void write(const char* path, const Pixels& pixels) {
  OIIO::attribute("threads", 1);
  const auto output = OIIO::ImageOutput::create(path);
  if (!output) throw std::runtime_error(OIIO::geterror());
  const auto type = pixels.bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
  OIIO::ImageSpec spec(pixels.width, pixels.height, static_cast<int>(pixels.channels.size()), type);
  spec.channelnames = pixels.channels;
  const auto alpha = std::find(pixels.channels.begin(), pixels.channels.end(), "A");
  if (alpha != pixels.channels.end()) {
    spec.alpha_channel = static_cast<int>(alpha - pixels.channels.begin());
  }
  spec.attribute("oiio:ColorSpace", pixels.bytes ? "sRGB" : "Linear");
  if (pixels.bytes) spec.attribute("oiio:UnassociatedAlpha", 1);
  // Otherwise, OpenImageIO would store the time, so that no two files would be equal.
  if (std::string(output->format_name()) == "tiff") spec.attribute("DateTime", "");
  for (const auto& [name, value] : pixels.attributes) spec.attribute(name, value);
  const void* const data = pixels.bytes ? static_cast<const void*>(pixels.bytes)
                                        : static_cast<const void*>(pixels.floats);
  if (!output->open(path, spec) || !output->write_image(type, data) || !output->close()) {
    throw std::runtime_error(output->geterror());
  }
  if (!kinome::openimageio::clear_varying_bytes(path, output->format_name(),
                                                pixels.attributes.count("ImageDescription") > 0)) {
    throw std::runtime_error("can't write the header");
  }
}

}  // namespace

extern "C" KINOME_EXPORT bool kinome_find_image_writer(const char* extension,
                                                       WriterTraits& traits) {
  try {
    const auto output = OIIO::ImageOutput::create(std::string("image") + extension);
    if (!output || has(kOtherFormats, output->format_name())) {
      OIIO::geterror();  // clears it
      return false;
    }
    traits.is_linear = has(kLinearFormats, output->format_name());
    traits.limits = kinome::openimageio::size_limits(output->format_name());
    traits.has_alpha = output->supports("alpha") != 0;
    return true;
  } catch (...) {
    return false;
  }
}

extern "C" KINOME_EXPORT bool kinome_write_image(const char* path, const Pixels& pixels,
                                                 std::string& error) {
  try {
    write(path, pixels);
    return true;
  } catch (const std::exception& failure) {
    error = *failure.what() ? failure.what() : "unknown error";
    return false;
  } catch (...) {
    error = "unknown error";
    return false;
  }
}

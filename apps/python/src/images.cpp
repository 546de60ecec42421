// The compiled Python module kinome._images: image files by OpenImageIO. It is separate from
// kinome._kinome, because OpenImageIO takes a quarter of a second to load.

#include <OpenImageIO/imageio.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <stdexcept>

#include "image_files/openimageio/size_limits.h"
#include "image_files/openimageio/varying_bytes.h"

namespace {

namespace nb = nanobind;
using Pixels = nb::ndarray<nb::c_contig, nb::device::cpu, nb::ndim<3>>;

constexpr uint64_t kMaxBytes = uint64_t{1} << 36;  ///< of the pixels of a file

/// A type of pixels in OpenImageIO and in numpy.
struct PixelType {
  OIIO::TypeDesc::BASETYPE base;
  nb::dlpack::dtype_code code;
  uint8_t bits;
};
constexpr PixelType kTypes[] = {
    {OIIO::TypeDesc::UINT8, nb::dlpack::dtype_code::UInt, 8},
    {OIIO::TypeDesc::INT8, nb::dlpack::dtype_code::Int, 8},
    {OIIO::TypeDesc::UINT16, nb::dlpack::dtype_code::UInt, 16},
    {OIIO::TypeDesc::INT16, nb::dlpack::dtype_code::Int, 16},
    {OIIO::TypeDesc::UINT32, nb::dlpack::dtype_code::UInt, 32},
    {OIIO::TypeDesc::INT32, nb::dlpack::dtype_code::Int, 32},
    {OIIO::TypeDesc::HALF, nb::dlpack::dtype_code::Float, 16},
    {OIIO::TypeDesc::FLOAT, nb::dlpack::dtype_code::Float, 32},
    {OIIO::TypeDesc::DOUBLE, nb::dlpack::dtype_code::Float, 64},
};

const PixelType& type_of(OIIO::TypeDesc::BASETYPE base) {
  for (const PixelType& type : kTypes) {
    if (type.base == base) return type;
  }
  throw std::runtime_error("its pixels have an unsupported type");
}

OIIO::TypeDesc type_of(const Pixels& pixels) {
  for (const PixelType& type : kTypes) {
    const nb::dlpack::dtype given = pixels.dtype();
    if (given.code == static_cast<uint8_t>(type.code) && given.bits == type.bits) return type.base;
  }
  throw std::runtime_error("pixels of this type can't be written");
}

/// Returns a text of a file, in which invalid UTF-8 is replaced.
nb::object text_of(const std::string& text) {
  return nb::steal(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
}

/// Reads the first image of a file. Returns (array (height, width, channels) of the file's type,
/// names of the channels, attributes that are texts or numbers).
nb::tuple read_image(const std::string& path) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // colours as stored
  std::unique_ptr<OIIO::ImageInput> input;
  std::unique_ptr<std::byte[]> data;
  OIIO::ImageSpec spec;
  {
    const nb::gil_scoped_release release;
    input = OIIO::ImageInput::open(path, &config);
    if (!input) throw std::runtime_error(OIIO::geterror());
    spec = input->spec();
    if (spec.image_bytes() > kMaxBytes) throw std::runtime_error("it is too large");
    // A single type for all channels.
    spec.channelformats.clear();
    data = std::make_unique<std::byte[]>(spec.image_bytes());
    if (!input->read_image(0, 0, 0, spec.nchannels, spec.format, data.get())) {
      throw std::runtime_error(input->geterror());
    }
  }
  nb::list names;
  for (const std::string& name : spec.channelnames) names.append(text_of(name));
  nb::dict attributes;
  for (const OIIO::ParamValue& one : spec.extra_attribs) {
    if (one.type() == OIIO::TypeDesc::STRING) {
      attributes[one.name().c_str()] = text_of(one.get_string());
    } else if (one.type() == OIIO::TypeDesc::INT) {
      attributes[one.name().c_str()] = one.get_int();
    } else if (one.type() == OIIO::TypeDesc::FLOAT) {
      attributes[one.name().c_str()] = one.get_float();
    }
  }
  const PixelType& type = type_of(static_cast<OIIO::TypeDesc::BASETYPE>(spec.format.basetype));
  const size_t shape[] = {static_cast<size_t>(spec.height), static_cast<size_t>(spec.width),
                          static_cast<size_t>(spec.nchannels)};
  std::byte* const kept = data.release();
  const nb::capsule owner(kept, [](void* p) noexcept { delete[] static_cast<std::byte*>(p); });
  const nb::ndarray<nb::numpy> array(
      kept, 3, shape, owner, nullptr,
      nb::dlpack::dtype{static_cast<uint8_t>(type.code), type.bits, 1});
  return nb::make_tuple(array, names, attributes);
}

/// Writes a file in the format of its extension. `quality` is from 1 to 100, or 0 for the default.
void write_image(const std::string& path, const Pixels& pixels,
                 const std::vector<std::string>& channels, int quality,
                 const std::map<std::string, std::string>& attributes) {
  OIIO::ImageSpec spec(static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0)),
                       static_cast<int>(pixels.shape(2)), type_of(pixels));
  spec.channelnames = channels;
  spec.alpha_channel = -1;
  for (size_t c = 0; c < channels.size(); ++c) {
    if (channels[c] == "A") spec.alpha_channel = static_cast<int>(c);
  }
  spec["oiio:UnassociatedAlpha"] = 1;
  if (quality > 0) spec["CompressionQuality"] = quality;
  for (const auto& [name, value] : attributes) spec[name] = value;
  const nb::gil_scoped_release release;
  const auto output = OIIO::ImageOutput::create(path);
  if (!output) {
    OIIO::geterror();
    throw std::runtime_error(
        "unknown image format: use .exr, .pfm, .hdr or .png, or another format that OpenImageIO "
        "writes, such as .tif, .jpg, .webp, .tga or .bmp");
  }
  // Otherwise, OpenImageIO would store the time, so that no two files would be equal.
  if (std::string(output->format_name()) == "tiff" && !spec.find_attribute("DateTime")) {
    spec["DateTime"] = "";
  }
  const auto limits = kinome::openimageio::size_limits(output->format_name());
  if (!limits.contain(spec.width, spec.height)) {
    throw std::runtime_error("the format supports images of " + limits.text());
  }
  if (!output->open(path, spec) || !output->write_image(spec.format, pixels.data()) ||
      !output->close()) {
    throw std::runtime_error(output->geterror());
  }
  if (!kinome::openimageio::clear_varying_bytes(path, output->format_name(),
                                                attributes.count("ImageDescription") > 0)) {
    throw std::runtime_error("can't write the header");
  }
}

}  // namespace

NB_MODULE(_images, m) {
  nb::set_leak_warnings(false);
  OIIO::attribute("exr_threads", -1);
  m.def("read", &read_image);
  m.def("write", &write_image);
}

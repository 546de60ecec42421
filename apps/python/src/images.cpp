// The compiled Python module kinome._images: image files and resampling by OpenImageIO. It is
// separate from kinome._kinome, because OpenImageIO takes a quarter of a second to load.

#include <OpenImageIO/filter.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

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
  nb::dict attributes;
  for (const OIIO::ParamValue& one : spec.extra_attribs) {
    if (one.type() == OIIO::TypeDesc::STRING) {
      attributes[one.name().c_str()] = one.get_string();
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
  return nb::make_tuple(array, spec.channelnames, attributes);
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
  if (!output) throw std::runtime_error(OIIO::geterror());
  if (!output->open(path, spec) || !output->write_image(spec.format, pixels.data()) ||
      !output->close()) {
    throw std::runtime_error(output->geterror());
  }
}

/// Separable filter whose values are interpolated in a table. It is wider along an axis by `scale`.
class TableFilter final : public OIIO::Filter2D {
 public:
  TableFilter(const std::vector<float>& values, float radius, float x_scale, float y_scale)
      : Filter2D(2 * radius * x_scale, 2 * radius * y_scale),
        values_(values),
        x_step_(radius * x_scale / static_cast<float>(values.size() - 1)),
        y_step_(radius * y_scale / static_cast<float>(values.size() - 1)) {}
  bool separable() const override { return true; }
  float operator()(float x, float y) const override { return xfilt(x) * yfilt(y); }
  float xfilt(float x) const override { return at(std::abs(x) / x_step_); }
  float yfilt(float y) const override { return at(std::abs(y) / y_step_); }
  OIIO::string_view name() const override { return "table"; }

 private:
  float at(float index) const {
    const float last = static_cast<float>(values_.size() - 1);
    if (!(index <= last)) return 0;
    const auto i = static_cast<size_t>(std::min(index, last - 1));
    const float t = index - static_cast<float>(i);
    return values_[i] * (1 - t) + values_[i + 1] * t;
  }
  const std::vector<float>& values_;
  float x_step_, y_step_;
};

/// Resamples an image with a separable, symmetric filter. `filter` has its values at equidistant
/// offsets from 0 to `radius`, in pixels of the image that has fewer pixels along an axis.
nb::object resample_image(
    const nb::ndarray<float, nb::c_contig, nb::device::cpu, nb::ndim<3>>& pixels, int width,
    int height, const std::vector<float>& filter, float radius) {
  if (filter.size() < 2) throw std::runtime_error("a filter needs two values or more");
  const OIIO::ImageSpec spec(static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0)),
                             static_cast<int>(pixels.shape(2)), OIIO::TypeDesc::FLOAT);
  const OIIO::ImageSpec resized(width, height, spec.nchannels, OIIO::TypeDesc::FLOAT);
  // OpenImageIO evaluates the filter at offsets in pixels of the result.
  const auto scale = [](int before, int after) {
    return std::max(1.f, static_cast<float>(after) / static_cast<float>(before));
  };
  TableFilter table(filter, radius, scale(spec.width, width), scale(spec.height, height));
  auto values = std::make_unique<float[]>(resized.image_pixels() * resized.nchannels);
  {
    const nb::gil_scoped_release release;
    const OIIO::ImageBuf source(spec, pixels.data());
    OIIO::ImageBuf result(resized, values.get());
    if (!OIIO::ImageBufAlgo::resize(result, source, &table)) {
      throw std::runtime_error(result.geterror());
    }
  }
  const size_t shape[] = {static_cast<size_t>(height), static_cast<size_t>(width),
                          static_cast<size_t>(spec.nchannels)};
  float* const kept = values.release();
  const nb::capsule owner(kept, [](void* p) noexcept { delete[] static_cast<float*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, float>(kept, 3, shape, owner));
}

}  // namespace

NB_MODULE(_images, m) {
  nb::set_leak_warnings(false);
  OIIO::attribute("exr_threads", -1);
  m.def("read", &read_image);
  m.def("write", &write_image);
  m.def("resample", &resample_image);
}

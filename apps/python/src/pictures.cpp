#include "pictures.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "kinome/error.h"
#include "kinome/image_files.h"
#include "kinome/output_files.h"
#include "output_files/file_writer.h"

namespace kinome::python {
namespace {

Image to_picture(nb::object array, const std::vector<std::string>& channels) {
  const auto pixels = nb::cast<nb::ndarray<const float, nb::c_contig, nb::ndim<3>>>(array);
  if (pixels.shape(2) != channels.size()) {
    throw Error("a picture of " + std::to_string(pixels.shape(2)) +
                " channels must have as many names, got " + std::to_string(channels.size()));
  }
  return {static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0)), channels,
          std::vector<float>(pixels.data(), pixels.data() + pixels.size())};
}

}  // namespace

void write_picture(const std::string& path, nb::object array,
                   const std::vector<std::string>& channels,
                   const std::map<std::string, std::string>& header) {
  const Image image = to_picture(std::move(array), channels);
  const nb::gil_scoped_release release;
  const std::string extension = lower_extension(path);
  if (extension == ".png") return kinome::write_png(path, image, 0);
  if (extension == ".pfm") return kinome::write_pfm(path, image);
  if (extension != ".exr") throw Error(Location{path, 0, 0}, "must end in .exr, .pfm or .png");
  write_exr(path, image, ExrSampleType::kFloat, header);
}

nb::bytes encode_picture(nb::object array, const std::vector<std::string>& channels) {
  const std::string bytes = encode_png("the image", to_picture(std::move(array), channels), 0);
  return nb::bytes(bytes.data(), bytes.size());
}

void write_bytes(const std::string& path, const nb::bytes& bytes) {
  const std::string text(bytes.c_str(), bytes.size());
  const nb::gil_scoped_release release;
  write_text(path, text);
}

}  // namespace kinome::python

#include "denoise.h"

#include <nanobind/ndarray.h>

#include "kinome/denoise.h"
#include "kinome/error.h"
#include "values.h"

namespace kinome::python {
namespace {

/// Values of a Python array (height, width, 3); empty for None. Throws Error if its size isn't that
/// of `input`.
std::vector<float> pixels_of(const nb::object& array, const char* name, DenoiserInput& input) {
  if (array.is_none()) return {};
  const auto pixels = nb::cast<nb::ndarray<const float, nb::c_contig, nb::ndim<3>>>(array);
  const auto height = static_cast<int>(pixels.shape(0)), width = static_cast<int>(pixels.shape(1));
  if (input.width == 0) input.width = width, input.height = height;
  if (pixels.shape(2) != 3 || width != input.width || height != input.height) {
    throw Error(std::string(name) + " must have the picture's size and three channels");
  }
  return {pixels.data(), pixels.data() + pixels.size()};
}

}  // namespace

nb::object denoise(const nb::object& color, const nb::object& albedo, const nb::object& normal,
                   const nb::object& variance, unsigned threads, const std::string& library) {
  DenoiserInput input;
  input.color = pixels_of(color, "the picture", input);
  input.albedo = pixels_of(albedo, "albedo", input);
  input.normal = pixels_of(normal, "normal", input);
  const std::vector<float> noise = pixels_of(variance, "variance", input);
  Image result{input.width, input.height, {"R", "G", "B"}, {}};
  {
    const nb::gil_scoped_release release;
    result.data = open_image_denoise(threads, library)(input);
    if (!noise.empty()) {
      result.data = combine_with_noisy(input.color, noise, result.data, input.width, input.height);
    }
  }
  return picture_array(std::move(result));
}

}  // namespace kinome::python

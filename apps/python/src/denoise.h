#pragma once

#include <nanobind/nanobind.h>

#include <string>

namespace kinome::python {

namespace nb = nanobind;

/// Denoises a colour of shape (height, width, 3), as a Python array of floats. Other arrays have
/// the same shape, or are None. `library`: see open_image_denoise(). Throws Error.
nb::object denoise(const nb::object& color, const nb::object& albedo, const nb::object& normal,
                   const nb::object& variance, unsigned threads, const std::string& library);

}  // namespace kinome::python

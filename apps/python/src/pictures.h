#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <string>
#include <vector>

namespace kinome::python {

namespace nb = nanobind;

/// Writes an array (height, width, channels) of floats to a .exr, .pfm or .png file. Throws Error,
/// also for a file that a loaded scene reads.
void write_picture(const std::string& path, nb::object array,
                   const std::vector<std::string>& channels,
                   const std::map<std::string, std::string>& header);
/// Returns the bytes of the PNG file that write_picture() would write.
nb::bytes encode_picture(nb::object array, const std::vector<std::string>& channels);
/// Writes a file of these bytes. Throws Error like write_picture().
void write_bytes(const std::string& path, const nb::bytes& bytes);

}  // namespace kinome::python

#pragma once

#include <ImfHeader.h>
#include <ImfIO.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <string>

#include "kinome/image.h"

/// Helpers shared by all code that reads and writes files with OpenEXR.
namespace kinome {

/// Makes the threads of set_image_file_threads() available to OpenEXR, if a file with this number
/// of bytes is large enough to need them.
void use_threads_for(uint64_t bytes);

/// Calls `write` with a stream that writes to `path`, which is afterwards either complete or
/// unchanged. Throws Error if writing fails.
void write_by_openexr(const std::string& path, const std::function<void(Imf::OStream&)>& write);

/// Returns the message for users about an exception of OpenEXR's readers or of check_exr().
std::string why_unreadable(const std::exception& error);

/// Adds the header's string attributes to `metadata`.
void read_metadata(const Imf::Header& header, ImageMetadata& metadata);

}  // namespace kinome

#pragma once

#include <ImfHeader.h>
#include <ImfIO.h>

#include <exception>
#include <functional>
#include <string>

#include "kinome/image.h"

/// What all that reads and writes by OpenEXR has in common.
namespace kinome {

/// `write` writes a file to the stream that it is given: `path` is whole then, or what it was.
/// Throws Error where that can't be done.
void write_by_openexr(const std::string& path, const std::function<void(Imf::OStream&)>& write);

/// What people are told of a file that OpenEXR, or check_exr, can't read for this reason.
std::string why_unreadable(const std::exception& error);

/// The header's attributes that are texts.
void read_metadata(const Imf::Header& header, ImageMetadata& metadata);

}  // namespace kinome

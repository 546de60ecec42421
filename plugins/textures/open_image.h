#pragma once

#include <string>

#include "image_reader.h"
#include "kinome/properties.h"

namespace kinome {

/// Reads a file that the core can't, through the library of ReadImageFunction, which is opened now.
/// Throws an Error at the file, or, where that library can't be opened, at the parameter
/// `filename`. Thread-safe.
StoredImage open_image(const std::string& path, const Properties& props);

}  // namespace kinome

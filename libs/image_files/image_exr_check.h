#pragma once

#include <string>

namespace kinome {

/// Checks a file before OpenEXR reads it, because OpenEXR allocates the memory that headers claim
/// before it reads a pixel. Throws std::runtime_error with the reason if the file is not an
/// OpenEXR file, is truncated or damaged, or claims more pixels than it can contain. Thread-safe.
void check_exr(const std::string& path);

}  // namespace kinome

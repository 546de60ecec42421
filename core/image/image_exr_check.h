#pragma once

#include <string>

namespace kinome {

/// Whether OpenEXR may be trusted with a file: it takes as much memory as headers claim to need,
/// before it has read a pixel. Throws std::runtime_error with the reason where the file is not
/// OpenEXR, is truncated or damaged, or promises more than it can hold. Safe from any thread.
void check_exr(const std::string& path);

}  // namespace kinome

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/math.h"

/// Messages of the network protocol of the viewer tev:
/// https://github.com/Tom94/tev#over-the-network. Each begins with its length in bytes (including
/// these four) and its kind (one byte). Numbers are little-endian, strings zero-terminated.
namespace kinome::app::tev {

using Packet = std::vector<char>;

/// Returns a "CreateImage" message: creates and shows a black image, which replaces one of the same
/// name.
Packet create_image(const std::string& name, int width, int height,
                    const std::vector<std::string>& channels);
/// Returns an "UpdateImage" message, version 3. `data` is row by row with interleaved channels.
Packet update_image(const std::string& name, const Rect& pixels,
                    const std::vector<std::string>& channels, const std::vector<float>& data);

}  // namespace kinome::app::tev

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/math.h"

/// Messages of the viewer tev, by its network protocol:
/// https://github.com/Tom94/tev#over-the-network. Each begins with its length in bytes (with these
/// four) and its kind (one byte); numbers are little-endian, texts end with a zero.
namespace kinome::app::tev {

using Packet = std::vector<char>;

/// "CreateImage": a black image, in the place of one that has this name. The viewer shows it.
Packet create_image(const std::string& name, int width, int height,
                    const std::vector<std::string>& channels);
/// "UpdateImage", version 3: `data` is row by row, with the channels of a pixel side by side.
Packet update_image(const std::string& name, const Rect& pixels,
                    const std::vector<std::string>& channels, const std::vector<float>& data);

}  // namespace kinome::app::tev

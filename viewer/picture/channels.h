#pragma once

#include <array>
#include <string>
#include <vector>

#include "kinome/image.h"

namespace kinome::viewer {

/// What of an image is looked at: a colour of two or three channels, or a single one.
struct ChannelGroup {
  std::string name;          ///< "colour", "albedo", "depth", "A"
  std::array<int, 3> index;  ///< of its channels; the first `count` count
  int count;

  bool operator==(const ChannelGroup&) const = default;
};

/// All that an image can be looked at by: its colour first ("R", "G", "B", or "Y"), then other
/// channels of one name that end in ".R", ".G", ".B", in ".X", ".Y", ".Z" or in ".U", ".V"; then
/// each channel by itself.
std::vector<ChannelGroup> channel_groups(const Image& image);

/// The group of this name; where there is none, the first.
ChannelGroup group_named(const Image& image, const std::string& name);

}  // namespace kinome::viewer

#pragma once

#include <array>
#include <string>
#include <vector>

#include "kinome/image.h"

namespace kinome::viewer {

/// Channels of an image that are shown together: a colour of two or three channels, or one channel.
struct ChannelGroup {
  std::string name;          ///< "colour", "albedo", "depth", "A"
  std::array<int, 3> index;  ///< indices of the channels; only the first `count` are valid
  int count;

  bool operator==(const ChannelGroup&) const = default;
};

/// Returns all groups of an image. The first is its colour ("R", "G", "B", or "Y"), followed by
/// groups of channels with a common name that end in ".R", ".G", ".B", in ".X", ".Y", ".Z" or in
/// ".U", ".V". Then each channel is a group of its own.
std::vector<ChannelGroup> channel_groups(const Image& image);

/// Returns the group with this name, or the first group if there is none.
ChannelGroup group_named(const Image& image, const std::string& name);

}  // namespace kinome::viewer

#include "picture/channels.h"

#include <algorithm>
#include <string_view>

namespace kinome::viewer {
namespace {

constexpr std::array<std::string_view, 3> kSuffixes = {"RGB", "XYZ", "UV"};

/// Adds the channels `prefix` + letter as a group, if all of them exist.
void add_group(const Image& image, const std::string& name, const std::string& prefix,
               std::string_view letters, std::vector<ChannelGroup>& groups) {
  ChannelGroup group{name, {-1, -1, -1}, static_cast<int>(letters.size())};
  for (size_t i = 0; i < letters.size(); ++i) {
    group.index[i] = image.find_channel(prefix + letters[i]);
    if (group.index[i] < 0) return;
  }
  groups.push_back(std::move(group));
}

}  // namespace

std::vector<ChannelGroup> channel_groups(const Image& image) {
  std::vector<ChannelGroup> groups;
  add_group(image, "colour", "", "RGB", groups);
  if (groups.empty()) add_group(image, "luminance", "", "Y", groups);
  for (const std::string& channel : image.channels) {
    for (const std::string_view letters : kSuffixes) {
      // The first channel of a group identifies it.
      if (channel.size() < 3 || !channel.ends_with(std::string(".") + letters[0])) continue;
      const std::string name = channel.substr(0, channel.size() - 2);
      add_group(image, name, name + ".", letters, groups);
    }
  }
  for (int c = 0; c < image.channel_count(); ++c) {
    groups.push_back({image.channels[c], {c, -1, -1}, 1});
  }
  return groups;
}

ChannelGroup group_named(const Image& image, const std::string& name) {
  const std::vector<ChannelGroup> groups = channel_groups(image);
  for (const ChannelGroup& group : groups) {
    if (group.name == name) return group;
  }
  return groups.empty() ? ChannelGroup{"", {-1, -1, -1}, 0} : groups.front();
}

}  // namespace kinome::viewer

#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kinome/error.h"
#include "kinome/math.h"

namespace kinome {

/// Image in memory: rows from top to bottom, with interleaved channels.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", "albedo.R", …
  std::vector<float> data;            ///< width x height x channels

  Image() = default;
  /// `values` may be empty if `data` is set before any pixel is read or written.
  Image(int columns, int rows, std::vector<std::string> channel_names, std::vector<float> values)
      : width(columns),
        height(rows),
        channels(std::move(channel_names)),
        data(std::move(values)) {}

  int channel_count() const { return static_cast<int>(channels.size()); }
  /// Returns the index of a channel, or -1.
  int find_channel(const std::string& name) const {
    const auto found = std::find(channels.begin(), channels.end(), name);
    return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
  }
  float& at(int x, int y, int c) {
    return data[(static_cast<size_t>(y) * width + x) * channels.size() + c];
  }
  float at(int x, int y, int c) const {
    return data[(static_cast<size_t>(y) * width + x) * channels.size() + c];
  }
};

/// String attributes in the header of an EXR file.
using ImageMetadata = std::map<std::string, std::string>;

}  // namespace kinome

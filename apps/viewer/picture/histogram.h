#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "picture/channels.h"

namespace kinome::viewer {

/// Histogram of a channel on a logarithmic axis. Bin i counts the values in
/// [least(i), least(i + 1)).
struct ChannelHistogram {
  static constexpr int kBins = 256;
  static constexpr int kBinsPerStop = 8;
  static constexpr int kFirstStop = -20;  ///< the axis covers 2^-20 to 2^12
  static float least(int bin);

  std::array<uint32_t, kBins> counts{};
  uint32_t below = 0;  ///< positive values below the axis
  uint32_t above = 0;  ///< finite values above the axis
  uint32_t zeros = 0;
  uint32_t negative = 0;  ///< finite
  uint32_t infinite = 0;
  uint32_t nan = 0;
  uint32_t underexposed = 0;      ///< finite values >= 0 that sRGB displays as black
  uint32_t overexposed = 0;       ///< values greater than 1 at this exposure, including infinity
  float lowest = 0, highest = 0;  ///< of finite values
  double mean = 0;                ///< of finite values
};

/// Returns the histograms of the group's channels. Takes about 10 ms for 1280x720 pixels.
std::vector<ChannelHistogram> histograms(const Image& image, const ChannelGroup& group,
                                         float exposure);

/// A value that is not finite, or is negative.
struct BadPixel {
  int x, y;
  std::string channel;
  float value;
};
/// Returns the first `limit` bad values of a group: NaN first, then infinite, then negative ones.
/// Of each kind, a pixel has one entry at most.
std::vector<BadPixel> bad_pixels(const Image& image, const ChannelGroup& group, size_t limit);

}  // namespace kinome::viewer

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "picture/channels.h"

namespace kinome::viewer {

/// How often which values are in a channel, on a logarithmic axis: bin i counts those of
/// [least(i), least(i + 1)).
struct ChannelHistogram {
  static constexpr int kBins = 256;
  static constexpr int kBinsPerStop = 8;
  static constexpr int kFirstStop = -20;  ///< the axis begins at 2^-20, and ends at 2^12
  static float least(int bin);

  std::array<uint32_t, kBins> counts{};
  uint32_t below = 0;  ///< > 0, but less than the axis has
  uint32_t above = 0;  ///< finite, but more
  uint32_t zeros = 0;
  uint32_t negative = 0;  ///< finite
  uint32_t infinite = 0;
  uint32_t nan = 0;
  uint32_t underexposed = 0;      ///< finite, >= 0, shown as black by sRGB's curve at this exposure
  uint32_t overexposed = 0;       ///< more than 1 at this exposure, not NaN
  float lowest = 0, highest = 0;  ///< of finite values
  double mean = 0;                ///< of finite values
};

/// One for each channel of the group. 1280x720 pixels take about ten milliseconds.
std::vector<ChannelHistogram> histograms(const Image& image, const ChannelGroup& group,
                                         float exposure);

/// A value that isn't finite, or is negative.
struct BadPixel {
  int x, y;
  std::string channel;
  float value;
};
/// The first `limit` of a group's: NaN first, then infinite ones, then negative ones, in each kind
/// one a pixel.
std::vector<BadPixel> bad_pixels(const Image& image, const ChannelGroup& group, size_t limit);

}  // namespace kinome::viewer

#include "picture/histogram.h"

#include <algorithm>
#include <cmath>

#include "kinome/color.h"
#include "picture/curves.h"

namespace kinome::viewer {
namespace {

constexpr float kStops =
    static_cast<float>(ChannelHistogram::kBins) / ChannelHistogram::kBinsPerStop;

/// Level i of the table is bin i.
const CurveTable& bin_table() {
  static const CurveTable table([](float x) {
    const float stops = std::log2(x) - ChannelHistogram::kFirstStop;
    return (ChannelHistogram::kBinsPerStop * stops - 0.4999f) / 255;
  });
  return table;
}

/// Returns the value below which 8-bit sRGB is black.
float min_visible() {
  return srgb_to_linear(0.5f / 255);
}

}  // namespace

float ChannelHistogram::least(int bin) {
  return std::exp2(kFirstStop + static_cast<float>(bin) / kBinsPerStop);
}

std::vector<ChannelHistogram> histograms(const Image& image, const ChannelGroup& group,
                                         float exposure) {
  const CurveTable& bins = bin_table();
  const float lowest_on_axis = ChannelHistogram::least(0);
  const float end_of_axis = std::exp2(ChannelHistogram::kFirstStop + kStops);
  const float dark = min_visible() * std::exp2(-exposure), bright = std::exp2(-exposure);
  const size_t pixels = static_cast<size_t>(image.width) * image.height;
  std::vector<ChannelHistogram> all(group.count);
  for (int c = 0; c < group.count; ++c) {
    ChannelHistogram& h = all[c];
    h.lowest = kInfinity;
    h.highest = -kInfinity;
    double sum = 0;
    const float* in = image.data.data() + group.index[c];
    for (size_t i = 0; i < pixels; ++i, in += image.channels.size()) {
      const float value = *in;
      if (std::isnan(value)) {
        ++h.nan;
        continue;
      }
      h.overexposed += value > bright;
      if (std::isinf(value)) {
        ++h.infinite;
        continue;
      }
      sum += value;
      h.lowest = std::min(h.lowest, value);
      h.highest = std::max(h.highest, value);
      if (value < 0) {
        ++h.negative;
        continue;
      }
      h.underexposed += value < dark;
      if (value == 0) {
        ++h.zeros;
      } else if (value < lowest_on_axis) {
        ++h.below;
      } else if (value >= end_of_axis) {
        ++h.above;
      } else {
        ++h.counts[bins.level(value)];
      }
    }
    const size_t finite = pixels - h.nan - h.infinite;
    h.mean = finite > 0 ? sum / static_cast<double>(finite) : 0;
    if (finite == 0) h.lowest = h.highest = 0;
  }
  return all;
}

std::vector<BadPixel> bad_pixels(const Image& image, const ChannelGroup& group, size_t limit) {
  std::vector<BadPixel> found;
  // The order is NaN, infinity, negative numbers.
  for (int kind = 0; kind < 3; ++kind) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < group.count; ++c) {
          const float value = image.at(x, y, group.index[c]);
          const int is = std::isnan(value) ? 0 : std::isinf(value) ? 1 : value < 0 ? 2 : 3;
          if (is != kind) continue;
          found.push_back({x, y, image.channels[group.index[c]], value});
          if (found.size() >= limit) return found;
          break;
        }
      }
    }
  }
  return found;
}

}  // namespace kinome::viewer

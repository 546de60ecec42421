#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinome/color.h"

namespace kinome::viewer {

/// Maps linear radiance >= 0 (1 is white) to linear light of the display in [0,1], per channel.
/// Compresses bright parts like film, by the fit of Narkowicz ("ACES Filmic Tone Mapping Curve",
/// 2015) to the ACES reference transform, with its exposure of 0.6. Increases everywhere; returns
/// 1 for infinity.
inline float filmic(float x) {
  const float exposed = 0.6f * std::min(x, 1e6f);
  const float value =
      exposed * (2.51f * exposed + 0.03f) / (exposed * (2.43f * exposed + 0.59f) + 0.14f);
  return std::min(value, 1.f);
}

/// Table of an increasing function with 256 levels. level(x) is exactly curve(x), clamped to [0,1],
/// times 255 and rounded. It takes one or two nanoseconds, independent of the curve. Immutable.
class CurveTable {
 public:
  static constexpr int kLevels = 256;

  /// `curve` must not decrease for floats >= 0.
  explicit CurveTable(const std::function<float(float)>& curve);

  /// Treats negative numbers and NaN as 0.
  uint8_t level(float x) const {
    if (!(x > 0)) return first_[0];
    const uint32_t bits = std::bit_cast<uint32_t>(x);
    uint32_t level = first_[bits >> kShift];
    // Only steep curves need more than one iteration.
    while (level + 1 < kLevels && bits >= min_bits_[level + 1]) ++level;
    return static_cast<uint8_t>(level);
  }

 private:
  /// Positive floats have the order of their bits. Floats with the same bits above kShift form a
  /// run, with 256 runs for each power of two.
  static constexpr int kShift = 15;
  std::array<uint32_t, kLevels> min_bits_;  ///< bits of the smallest float of each level
  std::vector<uint8_t> first_;              ///< level of the first float of each run
};

/// Maps [0,1] to sRGB colours. Perceived brightness increases evenly while the hue rotates:
/// cubehelix (Green 2011, "A colour scheme for the display of astronomical intensity images", with
/// his values: start 0.5, -1.5 rotations, hue 1).
Rgb cubehelix(float t);
/// Maps [-1,1] to sRGB colours: 0 is black, negative values are blue, positive ones red. Both ends
/// are pale.
Rgb signed_color(float t);

using ColorMap = std::array<std::array<uint8_t, 3>, 256>;

/// Colour maps for values without a sign.
enum class Map {
  kCubehelix,  ///< cubehelix(), from black to white
  kViridis,    ///< viridis of Matplotlib (Smith and van der Walt 2015): uniform to all viewers
  kTurbo       ///< turbo (Mikhailov 2019, "Turbo, An Improved Rainbow Colormap"): many hues
};
inline constexpr Map kMaps[] = {Map::kCubehelix, Map::kViridis, Map::kTurbo};
const char* to_string(Map map);
/// Returns the colours of a map. Those of viridis and turbo are interpolated from every eighth
/// colour, with errors of two levels at most.
const ColorMap& color_map(Map map);
/// Index 0 is the colour of -1, 255 that of 1. Indices 127 and 128 are black.
const ColorMap& signed_map();

/// Range of values that a colour map covers.
struct ColorRange {
  float low = 0.001f;  ///< > 0 if logarithmic
  float high = 10;
  bool is_logarithmic = true;

  /// Returns the position of a value in the range: 0 for low, 1 for high.
  float place(float value) const {
    if (is_logarithmic) return std::log(value / low) / std::log(high / low);
    return (value - low) / (high - low);
  }
  bool operator==(const ColorRange&) const = default;
};

/// A mark of a legend.
struct LegendMark {
  float place;       ///< position from 0 to 1
  std::string text;  ///< value at this position
};
/// Returns marks at powers of ten, with 2 and 5 times these for short ranges. Linear ranges get
/// marks at round numbers.
std::vector<LegendMark> legend_marks(const ColorRange& range);

}  // namespace kinome::viewer

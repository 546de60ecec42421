#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kinome/color.h"

namespace kinome::viewer {

/// What a display is told to show of radiance (linear, 1 is white), as linear light in [0,1]:
/// bright parts are compressed as film does, by the fit of Narkowicz ("ACES Filmic Tone Mapping
/// Curve", 2015) to the ACES reference transform, exposed by 0.6 as that is. Per channel; rises
/// everywhere. x >= 0; infinite: 1.
inline float filmic(float x) {
  const float exposed = 0.6f * std::min(x, 1e6f);
  const float value =
      exposed * (2.51f * exposed + 0.03f) / (exposed * (2.43f * exposed + 0.59f) + 0.14f);
  return std::min(value, 1.f);
}

/// A map of [0,1] to sRGB colours whose perceived brightness rises evenly while the hue goes round:
/// cubehelix (Green 2011, "A colour scheme for the display of astronomical intensity images", with
/// his values: start 0.5, -1.5 rotations, hue 1).
Rgb cubehelix(float t);
/// A map of [-1,1] with black in the middle: negative is blue, positive red, far ends are pale.
Rgb signed_color(float t);

using ColorMap = std::array<std::array<uint8_t, 3>, 256>;
const ColorMap& cubehelix_map();
/// Of -1 at 0 to 1 at 255; 128 is 0.
const ColorMap& signed_map();

/// Which numbers a map of colours stands for.
struct ColorRange {
  float low = 0.001f;  ///< > 0 where logarithmic
  float high = 10;
  bool is_logarithmic = true;

  /// Where a number lies, 0 at low and 1 at high.
  float place(float value) const {
    if (is_logarithmic) return std::log(value / low) / std::log(high / low);
    return (value - low) / (high - low);
  }
  bool operator==(const ColorRange&) const = default;
};

/// A mark of a legend: where it is, from 0 to 1, and the number that is there.
struct LegendMark {
  float place;
  std::string text;
};
/// Powers of ten, and what lies between where there are few of them; or round numbers.
std::vector<LegendMark> legend_marks(const ColorRange& range);

}  // namespace kinome::viewer

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinome/color.h"
#include "kinome/image.h"
#include "picture/channels.h"
#include "picture/curve_table.h"
#include "picture/curves.h"

namespace kinome::viewer {

enum class Curve {
  kSrgb,        ///< as it is: what is more than 1 is white
  kFilmic,      ///< bright parts compressed: filmic()
  kFalseColor,  ///< the value, or a colour's luminance, by cubehelix()
  kSigned,      ///< the same by signed_color(), from -range.high to range.high, linear
};
const char* to_string(Curve curve);

/// How an image is shown. Applies to any image.
struct Tone {
  std::string group = "colour";  ///< see group_named()
  float exposure = 0;            ///< in stops; not of false colours, which have a range
  Curve curve = Curve::kSrgb;
  ColorRange range;
  /// Values that can't be shown stand out: NaN in magenta, infinite ones in cyan. Otherwise they
  /// are as 0, or as the brightest.
  bool marks = true;
  /// Negative ones in green, unless the range has negative numbers. Control variates and filters
  /// make some that are right.
  bool marks_negative = false;

  bool operator==(const Tone&) const = default;
};

/// What a pixel that can't be shown is drawn in.
inline constexpr std::array<uint8_t, 3> kNanColor{255, 0, 255};
inline constexpr std::array<uint8_t, 3> kInfiniteColor{0, 255, 255};
inline constexpr std::array<uint8_t, 3> kNegativeColor{0, 200, 0};

/// Makes pixels for a display (8-bit sRGB) of images, by a Tone. Immutable; making one takes a
/// millisecond, mapping 1280x720 pixels about ten on one core.
class ToneMapper {
 public:
  explicit ToneMapper(const Tone& tone);

  const Tone& tone() const { return tone_; }
  /// R, G, B and 255 of each of an image's `pixels`, row by row, into 4 bytes each, `stride` bytes
  /// from row to row.
  void map(const Image& image, const Rect& pixels, uint8_t* out, size_t stride) const;
  /// Of all of an image.
  std::vector<uint8_t> map(const Image& image) const;

 private:
  void map_colors(const float* in, int channels, const ChannelGroup& group, int count,
                  uint8_t* out) const;
  void map_values(const float* in, int channels, const ChannelGroup& group, int count,
                  uint8_t* out) const;

  Tone tone_;
  float factor_;
  CurveTable table_;
};

/// The linear light in [0,1] that a display is told to show of a colour, by kSrgb or kFilmic: what
/// differences are seen in. What isn't finite or is negative counts as 0, or 1 where infinite.
Rgb displayed(const Rgb& color, float exposure, Curve curve);

/// The range of a group's values, between the darkest and the brightest hundredth of those that are
/// finite (and > 0 where logarithmic), rounded outward to 1, 2 or 5 times a power of ten.
ColorRange range_of(const Image& image, const ChannelGroup& group, bool is_logarithmic);

}  // namespace kinome::viewer

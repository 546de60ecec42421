#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinome/color.h"
#include "kinome/image.h"
#include "picture/channels.h"
#include "picture/curves.h"

namespace kinome::viewer {

enum class Curve {
  kSrgb,        ///< unchanged; values above 1 are white
  kFilmic,      ///< compresses bright parts: filmic()
  kFalseColor,  ///< maps the value, or the luminance of a colour, by a colour map
  kSigned,      ///< maps it linearly by signed_color(), from -range.high to range.high
};
const char* to_string(Curve curve);

/// Settings for the display of an image. They apply to any image.
struct Tone {
  std::string group = "colour";  ///< see group_named()
  float exposure = 0;            ///< in stops; ignored by false colours, which use `range`
  Curve curve = Curve::kSrgb;
  ColorRange range;
  Map map = Map::kCubehelix;  ///< for kFalseColor
  /// Displays NaN in magenta and infinite values in cyan. If false, NaN appears as 0, and infinity
  /// as the brightest value.
  bool marks = true;
  /// Displays negative values in green, unless the range contains negative values. Control variates
  /// and filters produce negative values that are correct.
  bool marks_negative = false;

  bool operator==(const Tone&) const = default;
};

/// Colours of pixels that can't be displayed.
inline constexpr std::array<uint8_t, 3> kNanColor{255, 0, 255};
inline constexpr std::array<uint8_t, 3> kInfiniteColor{0, 255, 255};
inline constexpr std::array<uint8_t, 3> kNegativeColor{0, 200, 0};

/// Converts images to display pixels (8-bit sRGB). Immutable. Construction takes 1 ms; mapping
/// 1280x720 pixels takes about 10 ms on one core.
class ToneMapper {
 public:
  explicit ToneMapper(const Tone& tone);

  const Tone& tone() const { return tone_; }
  /// Writes R, G, B and 255 for each pixel in the rectangle `pixels`, with 4 bytes per pixel and
  /// `stride` bytes per row.
  void map(const Image& image, const Rect& pixels, uint8_t* out, size_t stride) const;
  /// Maps the whole image.
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

/// Returns the linear light in [0,1] with which a display shows a colour, by kSrgb or kFilmic. NaN
/// and negative values become 0, infinity becomes 1.
Rgb displayed(const Rgb& color, float exposure, Curve curve);

/// Returns the range between the 1st and 99th percentile of a group's values, rounded outward to 1,
/// 2 or 5 times a power of ten. Uses only finite values, which must be > 0 if logarithmic.
ColorRange range_of(const Image& image, const ChannelGroup& group, bool is_logarithmic);

}  // namespace kinome::viewer

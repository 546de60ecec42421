#include "picture/tone.h"

#include <algorithm>
#include <cmath>

namespace kinome::viewer {
namespace {

/// Kinds of values that can't be displayed, from good to worst.
enum Badness { kFine, kNegative, kInfinite, kNan };

Badness badness(float value) {
  if (std::isnan(value)) return kNan;
  if (std::isinf(value)) return kInfinite;
  return value < 0 ? kNegative : kFine;
}

/// Returns the worst value of the channels.
Badness badness(const float* pixel, const ChannelGroup& group) {
  Badness worst = kFine;
  for (int c = 0; c < group.count; ++c) worst = std::max(worst, badness(pixel[group.index[c]]));
  return worst;
}

void put(const std::array<uint8_t, 3>& color, uint8_t* out) {
  std::copy(color.begin(), color.end(), out);
}

void mark(Badness bad, const Tone& tone, uint8_t* out) {
  if (bad == kNan && tone.marks) put(kNanColor, out);
  if (bad == kInfinite && tone.marks) put(kInfiniteColor, out);
  if (bad == kNegative && tone.marks_negative) put(kNegativeColor, out);
}

CurveTable table_of(const Tone& tone) {
  switch (tone.curve) {
    case Curve::kSrgb:
      return CurveTable([](float x) { return linear_to_srgb(std::min(x, 1.f)); });
    case Curve::kFilmic:
      return CurveTable([](float x) { return linear_to_srgb(filmic(x)); });
    case Curve::kFalseColor:
      if (tone.range.is_logarithmic && tone.range.low > 0 && tone.range.high > tone.range.low) {
        return CurveTable([&](float x) { return tone.range.place(x); });
      }
      break;
    case Curve::kSigned:
      break;
  }
  return CurveTable([](float x) { return x; });
}

/// Maps low to 0 and high to 255, linearly; the values can be negative.
int linear_level(float value, float low, float high) {
  const float place = (value - low) / (high - low);
  if (!(place > 0)) return 0;
  return static_cast<int>(255 * std::min(place, 1.f) + 0.5f);
}

}  // namespace

const char* to_string(Curve curve) {
  constexpr const char* kNames[] = {"sRGB", "filmic", "false colour", "signed"};
  return kNames[static_cast<int>(curve)];
}

ToneMapper::ToneMapper(const Tone& tone)
    : tone_(tone), factor_(std::exp2(tone.exposure)), table_(table_of(tone)) {}

void ToneMapper::map(const Image& image, const Rect& pixels, uint8_t* out, size_t stride) const {
  const ChannelGroup group = group_named(image, tone_.group);
  const bool is_color = tone_.curve == Curve::kSrgb || tone_.curve == Curve::kFilmic;
  for (int y = pixels.y0; y < pixels.y1; ++y, out += stride) {
    if (group.count == 0) {
      std::fill_n(out, 4 * static_cast<size_t>(pixels.width()), uint8_t{255});
      continue;
    }
    const float* in = image.data.data() +
                      (static_cast<size_t>(y) * image.width + pixels.x0) * image.channels.size();
    if (is_color) {
      map_colors(in, image.channel_count(), group, pixels.width(), out);
    } else {
      map_values(in, image.channel_count(), group, pixels.width(), out);
    }
  }
}

std::vector<uint8_t> ToneMapper::map(const Image& image) const {
  std::vector<uint8_t> out(static_cast<size_t>(image.width) * image.height * 4);
  if (!out.empty()) {
    map(image, {0, 0, image.width, image.height}, out.data(), 4 * static_cast<size_t>(image.width));
  }
  return out;
}

void ToneMapper::map_colors(const float* in, int channels, const ChannelGroup& group, int count,
                            uint8_t* out) const {
  // Two channels are displayed as red and green.
  const int r = group.index[0], g = group.count > 1 ? group.index[1] : r;
  const int b = group.count > 2 ? group.index[2] : group.count == 1 ? r : -1;
  const bool has_marks = tone_.marks || tone_.marks_negative;
  for (int i = 0; i < count; ++i, in += channels, out += 4) {
    out[0] = table_.level(factor_ * in[r]);
    out[1] = table_.level(factor_ * in[g]);
    out[2] = b < 0 ? 0 : table_.level(factor_ * in[b]);
    out[3] = 255;
    if (has_marks) mark(badness(in, group), tone_, out);
  }
}

void ToneMapper::map_values(const float* in, int channels, const ChannelGroup& group, int count,
                            uint8_t* out) const {
  const bool is_signed = tone_.curve == Curve::kSigned;
  const ColorMap& colors = is_signed ? signed_map() : color_map(tone_.map);
  const ColorRange& range = tone_.range;
  const float low = is_signed ? -range.high : range.low;
  const bool is_linear = is_signed || !range.is_logarithmic;
  const bool has_negative = is_linear && low < 0;
  const bool has_marks = tone_.marks || tone_.marks_negative;
  for (int i = 0; i < count; ++i, in += channels, out += 4) {
    float value = in[group.index[0]];
    if (group.count == 3) {
      value = luminance({in[group.index[0]], in[group.index[1]], in[group.index[2]]});
    }
    put(colors[is_linear ? linear_level(value, low, range.high) : table_.level(value)], out);
    out[3] = 255;
    if (!has_marks) continue;
    const Badness bad = badness(in, group);
    if (bad != kNegative || !has_negative) mark(bad, tone_, out);
  }
}

Rgb displayed(const Rgb& color, float exposure, Curve curve) {
  Rgb shown;
  for (int c = 0; c < 3; ++c) {
    const float x = color[c] > 0 ? color[c] * std::exp2(exposure) : 0;  // NaN: 0
    shown[c] = curve == Curve::kFilmic ? filmic(x) : std::min(x, 1.f);
  }
  return shown;
}

ColorRange range_of(const Image& image, const ChannelGroup& group, bool is_logarithmic) {
  std::vector<float> values;
  const size_t count = static_cast<size_t>(image.width) * image.height;
  const size_t step = std::max<size_t>(1, count / 100'000);  // enough values for percentiles
  for (size_t i = 0; i < count && group.count > 0; i += step) {
    const float* in = image.data.data() + i * image.channels.size();
    float value = in[group.index[0]];
    if (group.count == 3) {
      value = luminance({in[group.index[0]], in[group.index[1]], in[group.index[2]]});
    }
    if (std::isfinite(value) && (!is_logarithmic || value > 0)) values.push_back(value);
  }
  ColorRange range{is_logarithmic ? 0.001f : 0, 1, is_logarithmic};
  if (values.empty()) return range;
  const auto at = [&](size_t index) {
    const auto nth = values.begin() + static_cast<ptrdiff_t>(index);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  const size_t last = values.size() - 1;
  const float low = at(last / 100), high = at(last - last / 100);
  // Rounds to 1, 2 or 5 times a power of ten.
  const auto rounded = [](float value, bool up) {
    if (value == 0) return 0.f;
    const bool grow = up == (value > 0);
    const double magnitude = std::abs(value),
                 power = std::pow(10, std::floor(std::log10(magnitude)));
    double found = grow ? 10 * power : power;
    for (const double factor : {2., 5.}) {
      if (grow && factor * power >= 0.9999 * magnitude) found = std::min(found, factor * power);
      if (!grow && factor * power <= 1.0001 * magnitude) found = factor * power;
    }
    if (grow && power >= 0.9999 * magnitude) found = power;
    return static_cast<float>(std::copysign(found, value));
  };
  range.low = rounded(low, false);
  range.high = rounded(high, true);
  if (!is_logarithmic && range.low > 0 && range.low < 0.3f * range.high) range.low = 0;
  if (!(range.high > range.low)) {
    range.high = is_logarithmic ? 10 * range.low : range.low + 1;
  }
  return range;
}

}  // namespace kinome::viewer

#include "picture/curves.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kinome::viewer {
namespace {

constexpr uint32_t kInfinityBits = 0x7f800000;

ColorMap make_map(Rgb (*color)(float), float low) {
  ColorMap map;
  for (int i = 0; i < 256; ++i) {
    const Rgb value = color(low + (1 - low) * static_cast<float>(i) / 255);
    for (int c = 0; c < 3; ++c) {
      map[i][c] = static_cast<uint8_t>(std::lround(255 * std::clamp(value[c], 0.f, 1.f)));
    }
  }
  return map;
}

/// Colours of a map at 33 equidistant positions, as 0xRRGGBB.
using MapNodes = std::array<uint32_t, 33>;

constexpr MapNodes kViridisNodes = {
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453681, 0x424086, 0x3f4989,
    0x3b528b, 0x375a8d, 0x33638d, 0x2f6a8e, 0x2c728e, 0x297a8e, 0x26818e, 0x23898e,
    0x21908c, 0x1f988b, 0x1f9f88, 0x21a685, 0x28ae80, 0x31b57b, 0x3ebc74, 0x4cc26c,
    0x5dc963, 0x6ece58, 0x82d34c, 0x96d83f, 0xabdc32, 0xc0df24, 0xd5e21a, 0xeae51a,
    0xfde725};
constexpr MapNodes kTurboNodes = {
    0x30123b, 0x392a73, 0x4040a1, 0x4456c7, 0x466be3, 0x467ff6, 0x4293ff, 0x37a7fa,
    0x29bbec, 0x1dcdd8, 0x18dcc3, 0x1ee8b0, 0x31f299, 0x4cf97e, 0x6bfd64, 0x8aff4d,
    0xa3fd3c, 0xb8f735, 0xcced34, 0xdee037, 0xedd03a, 0xf8c03a, 0xfdae35, 0xfe982c,
    0xfb8022, 0xf56817, 0xec520f, 0xe04009, 0xd23105, 0xc02302, 0xac1701, 0x950d01,
    0x7a0403};

ColorMap interpolated(const MapNodes& nodes) {
  ColorMap map;
  for (size_t i = 0; i < map.size(); ++i) {
    const float place =
        static_cast<float>(i) * static_cast<float>(nodes.size() - 1) / (map.size() - 1);
    const size_t first = std::min(static_cast<size_t>(place), nodes.size() - 2);
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](size_t node) {
        return static_cast<float>(nodes[node] >> (16 - 8 * c) & 255);
      };
      const float value = std::lerp(at(first), at(first + 1), place - static_cast<float>(first));
      map[i][c] = static_cast<uint8_t>(std::lround(value));
    }
  }
  return map;
}

}  // namespace

Rgb cubehelix(float t) {
  t = std::clamp(t, 0.f, 1.f);
  const float angle = 2 * kPi * (0.5f / 3 + 1 - 1.5f * t);
  const float amplitude = t * (1 - t) / 2;
  const float c = amplitude * std::cos(angle), s = amplitude * std::sin(angle);
  return glm::clamp(
      Rgb(t - 0.14861f * c + 1.78277f * s, t - 0.29227f * c - 0.90649f * s, t + 1.97294f * c), 0.f,
      1.f);
}

Rgb signed_color(float t) {
  const float a = std::min(std::abs(t), 1.f);
  // From black to the full colour in the first two thirds, then toward white.
  const float strong = std::min(1.5f * a, 1.f), pale = std::max(0.f, 3 * a - 2);
  const Rgb hue = t < 0 ? Rgb(0.1f, 0.45f, 1) : Rgb(1, 0.3f, 0.1f);
  return glm::mix(strong * hue, Rgb(1), 0.75f * pale);
}

const char* to_string(Map map) {
  constexpr const char* kNames[] = {"cubehelix", "viridis", "turbo"};
  return kNames[static_cast<int>(map)];
}

const ColorMap& color_map(Map map) {
  static const std::array<ColorMap, 3> maps = {
      make_map(cubehelix, 0), interpolated(kViridisNodes), interpolated(kTurboNodes)};
  return maps[static_cast<size_t>(map)];
}

const ColorMap& signed_map() {
  static const ColorMap map = [] {
    ColorMap made = make_map(signed_color, -1);
    made[127] = made[128] = {0, 0, 0};
    return made;
  }();
  return map;
}

CurveTable::CurveTable(const std::function<float(float)>& curve)
    : first_((uint32_t{1} << 31) >> kShift) {
  const auto level_of = [&](uint32_t bits) {
    const float value = curve(std::bit_cast<float>(bits));
    return static_cast<int>(std::lround(255 * std::clamp(value, 0.f, 1.f)));
  };
  min_bits_[0] = 0;
  for (int level = 1; level < kLevels; ++level) {
    uint32_t below = min_bits_[level - 1], above = kInfinityBits;
    if (level_of(below) >= level) {
      above = below;
    } else if (level_of(kInfinityBits - 1) < level) {
      below = above;
    }
    while (above > below + 1 && above != below) {  // level_of(below) < level <= level_of(above)
      const uint32_t middle = below + (above - below) / 2;
      (level_of(middle) < level ? below : above) = middle;
    }
    min_bits_[level] = above;
  }
  int level = 0;
  for (uint32_t run = 0; run < first_.size(); ++run) {
    while (level + 1 < kLevels && run << kShift >= min_bits_[level + 1]) ++level;
    first_[run] = static_cast<uint8_t>(level);
  }
}

std::vector<LegendMark> legend_marks(const ColorRange& range) {
  std::vector<LegendMark> marks;
  if (!(range.high > range.low) || (range.is_logarithmic && !(range.low > 0))) return marks;
  const auto add = [&](double value) {
    const float place = range.place(static_cast<float>(value));
    if (place >= -1e-4f && place <= 1 + 1e-4f)
      marks.push_back({place, fmt::format("{:.4g}", value)});
  };
  if (range.is_logarithmic) {
    const double decades = std::log10(range.high / range.low);
    const int first = static_cast<int>(std::floor(std::log10(range.low)));
    const int last = static_cast<int>(std::ceil(std::log10(range.high)));
    const int step = std::max(1, static_cast<int>(std::ceil(decades / 8)));
    for (int power = first; power <= last; power += step) {
      const double value = std::pow(10, power);
      add(value);
      if (decades < 4) add(2 * value);
      if (decades < 4) add(5 * value);
    }
    return marks;
  }
  // The step is 1, 2 or 5 times a power of ten, for about five to ten marks.
  const double span = static_cast<double>(range.high) - range.low;
  double step = std::pow(10, std::floor(std::log10(span / 5)));
  for (const double factor : {5., 2.}) {
    if (span / (step * factor) >= 4) {
      step *= factor;
      break;
    }
  }
  for (double i = std::ceil(range.low / step - 1e-6); i * step <= range.high + 1e-6 * span; ++i) {
    add(i * step + 0.);  // avoids "-0"
  }
  return marks;
}

}  // namespace kinome::viewer

// Tests the viewer's images: curves, tone, false colours, histograms, channels.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/image_helpers.h"
#include "picture/channels.h"
#include "picture/histogram.h"
#include "picture/sphere.h"
#include "picture/tone.h"
#include "support/png.h"
#include "support/render.h"
#include "kinome/image_files.h"

namespace kinome::viewer::picture_tone_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// Returns values of all magnitudes, and the neighbours of each threshold.
std::vector<float> numbers() {
  std::vector<float> values = {0, 1e-45f, 1e-38f, std::numeric_limits<float>::max()};
  for (float x = 1e-6f; x < 1e4f; x *= 1.0007f) values.push_back(x);
  for (int level = 1; level < 256; ++level) {
    const float threshold = srgb_to_linear((static_cast<float>(level) - 0.5f) / 255);
    for (const float side : {0.f, 2.f}) values.push_back(std::nextafter(threshold, side));
  }
  return values;
}

Image row(const std::vector<float>& values, std::vector<std::string> channels) {
  const int width = static_cast<int>(values.size() / channels.size());
  return {width, 1, std::move(channels), values};
}

Tone tone(Curve curve, float exposure = 0) {
  Tone made;
  made.curve = curve;
  made.exposure = exposure;
  return made;
}

TEST(CurveTable, IsTheCurveRounded) {
  const auto flat_then_steep = [](float x) { return x < 0.1f ? 0.2f : x < 0.1001f ? 0.9f : 1.f; };
  const std::function<float(float)> curves[] = {
      [](float x) { return linear_to_srgb(std::min(x, 1.f)); },
      [](float x) { return linear_to_srgb(filmic(x)); },
      [](float x) { return std::log(x / 0.9f) / std::log(1.1f / 0.9f); },
      [](float x) { return std::log(x / 1e-5f) / std::log(1e10f); },
      flat_then_steep,
      [](float) { return 0.3f; },
  };
  for (const auto& curve : curves) {
    const CurveTable table(curve);
    for (const float x : numbers()) {
      const float value = std::clamp(curve(x), 0.f, 1.f);
      ASSERT_EQ(table.level(x), std::lround(255 * value)) << x << " of curve " << &curve - curves;
    }
    EXPECT_EQ(table.level(-1), table.level(0));
    EXPECT_EQ(table.level(kNan), table.level(0));
    EXPECT_GE(table.level(kInf), table.level(std::numeric_limits<float>::max()));
  }
}

TEST(Curves, FilmicRisesFromBlackToWhite) {
  EXPECT_EQ(filmic(0), 0);
  EXPECT_EQ(filmic(kInf), 1);
  // Computed by hand: 0.6 (2.51 x 0.6 + 0.03) / (0.6 (2.43 x 0.6 + 0.59) + 0.14).
  EXPECT_NEAR(filmic(1), 0.9216f / 1.3688f, 1e-6);
  float last = 0;
  for (float x = 1e-4f; x < 100; x *= 1.01f) {
    EXPECT_GE(filmic(x), last);
    last = filmic(x);
  }
  EXPECT_EQ(last, 1);
}

TEST(Curves, FalseColoursBrightenEvenly) {
  float last = -1;
  for (int i = 0; i <= 255; ++i) {
    const Rgb color = cubehelix(static_cast<float>(i) / 255);
    // cubehelix uses the perceived brightness of television (NTSC) for encoded colours; clipping
    // reduces it a little.
    const float brightness = glm::dot(color, Rgb(0.30f, 0.59f, 0.11f));
    EXPECT_GT(brightness, last) << i;
    EXPECT_NEAR(brightness, static_cast<float>(i) / 255, 0.03f) << i;
    last = brightness;
  }
  EXPECT_EQ(cubehelix(0), Rgb(0));
  EXPECT_EQ(cubehelix(1), Rgb(1));
  EXPECT_EQ(signed_color(0), Rgb(0));
  EXPECT_GT(signed_color(0.5f).x, signed_color(0.5f).z);
  EXPECT_LT(signed_color(-0.5f).x, signed_color(-0.5f).z);
}

TEST(Curves, MapsHaveThePublishedColours) {
  // Colours 0, 100 and 255 of Matplotlib 3.6.
  const std::array<std::array<uint8_t, 3>, 3> viridis = {{{68, 1, 84}, {42, 118, 142}, {253, 231, 37}}};
  const std::array<std::array<uint8_t, 3>, 3> turbo = {{{48, 18, 59}, {63, 246, 138}, {122, 4, 3}}};
  for (const auto& [map, colors] :
       {std::pair(Map::kViridis, viridis), std::pair(Map::kTurbo, turbo)}) {
    constexpr int kIndices[] = {0, 100, 255};
    for (int i = 0; i < 3; ++i) {
      const auto& color = color_map(map)[kIndices[i]];
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], colors[i][c], 2) << to_string(map) << i << c;
    }
  }
  // Viridis brightens evenly, too.
  for (int i = 1; i < 256; ++i) {
    const auto brightness = [](const std::array<uint8_t, 3>& color) {
      return 0.2126f * color[0] + 0.7152f * color[1] + 0.0722f * color[2];
    };
    EXPECT_GT(brightness(color_map(Map::kViridis)[i]) + 1,
              brightness(color_map(Map::kViridis)[i - 1]));
  }
}

TEST(Curves, LegendsHaveRoundNumbers) {
  const auto texts = [](const ColorRange& range) {
    std::string all;
    float last = -1;
    for (const LegendMark& mark : legend_marks(range)) {
      EXPECT_GT(mark.place, last);
      last = mark.place;
      all += mark.text + " ";
    }
    EXPECT_LE(last, 1.001f);
    return all;
  };
  EXPECT_EQ(texts({0.01f, 100, true}), "0.01 0.1 1 10 100 ");
  EXPECT_EQ(texts({0.1f, 1, true}), "0.1 0.2 0.5 1 ");
  EXPECT_EQ(texts({-1, 1, false}), "-1 -0.5 0 0.5 1 ");
  EXPECT_EQ(texts({0, 5, false}), "0 1 2 3 4 5 ");
  EXPECT_EQ(texts({1, 1, false}), "");
  EXPECT_EQ(texts({0, 1, true}), "");
}

TEST(Channels, AreGroupedByTheirNames) {
  const Image image = row(std::vector<float>(11), {"R", "G", "B", "A", "albedo.R", "albedo.G",
                                                   "albedo.B", "n.X", "n.Y", "n.Z", "depth"});
  std::string names;
  for (const ChannelGroup& group : channel_groups(image)) {
    names += group.name + (group.count == 1 ? " " : "* ");
  }
  EXPECT_EQ(names, "colour* albedo* n* R G B A albedo.R albedo.G albedo.B n.X n.Y n.Z depth ");
  EXPECT_EQ(group_named(image, "albedo").index, (std::array{4, 5, 6}));
  EXPECT_EQ(group_named(image, "depth").index[0], 10);
  EXPECT_EQ(group_named(image, "missing").name, "colour");
  EXPECT_EQ(group_named(row({1, 2}, {"Y", "A"}), "colour").name, "luminance");
  EXPECT_EQ(group_named(Image{}, "colour").count, 0);
}

TEST(Tone, MatchesThePng) {
  std::vector<float> values;
  for (const float x : numbers()) values.insert(values.end(), {x, x / 3, 7 * x});
  values.resize(values.size() / 3 * 3);
  const Image image = row(values, {"R", "G", "B"});
  const test::TemporaryFolder folder;
  write_png(folder.path("a.png"), image, -1.5f);
  const test::Png png = test::read_png(folder.path("a.png"));
  Tone unmarked = tone(Curve::kSrgb, -1.5f);
  unmarked.marks = false;  // marks of infinite values
  const auto shown = ToneMapper(unmarked).map(image);
  for (int x = 0; x < image.width; ++x) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(shown[4 * x + c], png.rgba[4 * x + c]) << image.at(x, 0, c);
    }
    ASSERT_EQ(shown[4 * x + 3], 255);
  }
}

TEST(Tone, RisesWithTheLight) {
  const Image image = row(numbers(), {"Y"});
  Tone false_color = tone(Curve::kFalseColor);
  false_color.range = {0.01f, 10, true};
  for (const Tone& each : {tone(Curve::kSrgb), tone(Curve::kFilmic), false_color}) {
    const auto shown = ToneMapper(each).map(row({0, 1e-6f, 0.02f, 0.1f, 0.5f, 3, 1e5f}, {"Y"}));
    for (size_t i = 4; i < shown.size(); i += 4) {
      EXPECT_GE(shown[i] + shown[i + 1] + shown[i + 2], shown[i - 4] + shown[i - 3] + shown[i - 2]);
    }
    EXPECT_EQ(shown[0] + shown[1] + shown[2], 0);
    EXPECT_EQ(shown[24] + shown[25] + shown[26], 3 * 255);
  }
}

TEST(Tone, MarksInvalidValues) {
  const Image image = row({kNan, 1, 1, kInf, -1, 1, -1, 1, 1, 1, 1, 1}, {"R", "G", "B"});
  const float max_float = std::numeric_limits<float>::max();
  const Image replaced = row({0, 1, 1, max_float, 0, 1, 0, 1, 1, 1, 1, 1}, {"R", "G", "B"});
  const auto pixel = [](const std::vector<uint8_t>& shown, int i) {
    return std::array<uint8_t, 3>{shown[4 * i], shown[4 * i + 1], shown[4 * i + 2]};
  };
  const std::array<uint8_t, 3> white{255, 255, 255};
  for (const Curve curve : {Curve::kSrgb, Curve::kFilmic, Curve::kFalseColor}) {
    Tone marked = tone(curve);
    marked.range = {0.01f, 1, true};
    marked.marks_negative = true;
    const auto shown = ToneMapper(marked).map(image);
    EXPECT_EQ(pixel(shown, 0), kNanColor);
    EXPECT_EQ(pixel(shown, 1), kInfiniteColor);
    EXPECT_EQ(pixel(shown, 2), kNegativeColor);
    EXPECT_EQ(pixel(shown, 3) == white, curve != Curve::kFilmic);
    marked.marks = marked.marks_negative = false;
    if (curve == Curve::kFalseColor) continue;  // it mixes all channels
    const auto unmarked = ToneMapper(marked).map(image);
    for (const int i : {0, 1, 2}) {
      EXPECT_EQ(pixel(unmarked, i), pixel(ToneMapper(marked).map(replaced), i));
    }
  }
  Tone with_sign = tone(Curve::kSigned);
  with_sign.marks_negative = true;
  with_sign.range.high = 1;
  const auto shown = ToneMapper(with_sign).map(image);
  EXPECT_EQ(pixel(shown, 0), kNanColor);
  EXPECT_NE(pixel(shown, 2), kNegativeColor);
  // Also maps a part of the image, and one without channels.
  std::vector<uint8_t> part(8);
  Tone marked = tone(Curve::kSrgb);
  marked.marks_negative = true;
  ToneMapper(marked).map(image, {2, 0, 4, 1}, part.data(), 8);
  EXPECT_EQ(pixel(part, 0), kNegativeColor);
  EXPECT_EQ(pixel(part, 1), white);
  EXPECT_EQ(ToneMapper(with_sign).map(Image{}).size(), 0u);
}

TEST(Tone, RangesContainAllValues) {
  const Image image = row({0.03f, 0.5f, 41, kNan, 0, -3}, {"Y"});
  const ChannelGroup group = group_named(image, "Y");
  const ColorRange logarithmic = range_of(image, group, true);
  EXPECT_FLOAT_EQ(logarithmic.low, 0.02f);
  EXPECT_FLOAT_EQ(logarithmic.high, 50);
  const ColorRange linear = range_of(image, group, false);
  EXPECT_FLOAT_EQ(linear.low, -5);
  EXPECT_FLOAT_EQ(linear.high, 50);
  const ColorRange none = range_of(row({kNan}, {"Y"}), {"Y", {0, -1, -1}, 1}, true);
  EXPECT_LT(none.low, none.high);
  const ColorRange even = range_of(row({2, 2}, {"Y"}), {"Y", {0, -1, -1}, 1}, false);
  EXPECT_LT(even.low, even.high);
}

TEST(Histogram, CountsEachValueOnce) {
  const std::vector<float> values = {0,    0,    1,     1.08f, 1.1f, 0.25f,   -2,
                                     kNan, kInf, -kInf, 1e-9f, 1e6f, 0.0001f, 2};
  const Image image = row(values, {"Y"});
  const auto all = histograms(image, group_named(image, "Y"), 0);
  ASSERT_EQ(all.size(), 1u);
  const ChannelHistogram& h = all[0];
  const int one = -ChannelHistogram::kFirstStop * ChannelHistogram::kBinsPerStop;
  EXPECT_EQ(ChannelHistogram::least(one), 1);
  EXPECT_EQ(h.counts[one], 2u);  // 2^(1/8) is 1.0905
  EXPECT_EQ(h.counts[one + 1], 1u);
  EXPECT_EQ(h.counts[one + 8], 1u);
  EXPECT_EQ(h.counts[one - 16], 1u);
  EXPECT_EQ(h.zeros, 2u);
  EXPECT_EQ(h.negative, 1u);
  EXPECT_EQ(h.nan, 1u);
  EXPECT_EQ(h.infinite, 2u);
  EXPECT_EQ(h.below, 1u);
  EXPECT_EQ(h.above, 1u);
  size_t total = h.zeros + h.negative + h.nan + h.infinite + h.below + h.above;
  for (const uint32_t count : h.counts) total += count;
  EXPECT_EQ(total, values.size());
  EXPECT_EQ(h.underexposed, 4u);  // 0, 0, 1e-9 and 0.0001
  EXPECT_EQ(h.overexposed, 5u);   // 1.08, 1.1, 2, 1e6 and infinity
  EXPECT_EQ(histograms(image, group_named(image, "Y"), 2)[0].overexposed, 6u);  // also 1
  EXPECT_EQ(h.lowest, -2);
  EXPECT_EQ(h.highest, 1e6f);

  const auto bad = bad_pixels(image, group_named(image, "Y"), 3);
  ASSERT_EQ(bad.size(), 3u);
  EXPECT_EQ(bad[0].x, 7);
  EXPECT_EQ(bad[1].x, 8);
  EXPECT_EQ(bad[2].x, 9);
  EXPECT_EQ(bad_pixels(image, group_named(image, "Y"), 9).size(), 4u);
}

TEST(Histogram, BinsMatchTheirStatedRanges) {
  for (int bin = 0; bin < ChannelHistogram::kBins; ++bin) {
    const float inside = ChannelHistogram::least(bin) * 1.0001f;
    const Image image = row({inside}, {"Y"});
    EXPECT_EQ(histograms(image, group_named(image, "Y"), 0)[0].counts[bin], 1u) << bin;
  }
}

TEST(Sphere, ShowsTheSideThatIsLookedAt) {
  const auto expect_direction = [](const Orbit& orbit, float x, float y, const Vec3& expected) {
    EXPECT_LT(glm::length(sphere_direction(orbit, x, y) - expected), 1e-6f);
  };
  expect_direction({0, 0}, 0, 0, {0, 0, 1});
  expect_direction({0, 0}, 1, 0, {1, 0, 0});
  expect_direction({0, 0}, 0, -1, {0, 1, 0});
  expect_direction({kPi / 2, 0}, 0, 0, {1, 0, 0});
  expect_direction({0, kPi / 2}, 0, 0, {0, 1, 0});
  EXPECT_EQ(sphere_direction({0, 0}, 0.8f, 0.8f).z, 2);

  // White where x > 0.
  Image map{1024, 512, {"R", "G", "B"}, {}};
  map.data.resize(size_t{1024} * 512 * 3);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 512; ++x) map.at(x, y, 0) = 1;
  }
  const Image picture = sphere_picture(map, {0, 0}, 64, 0.25f);
  EXPECT_EQ(picture.at(0, 0, 0), 0.25f);
  EXPECT_EQ(picture.at(20, 32, 0), 0);
  EXPECT_EQ(picture.at(44, 32, 0), 1);
}

}  // namespace
}  // namespace kinome::viewer::picture_tone_test

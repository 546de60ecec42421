// Tests the viewer's comparisons: FLIP and relMSE against other implementations, differences, and
// split views.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/image_helpers.h"
#include "picture/display.h"
#include "picture/inspector.h"
#include "support/render.h"

namespace kinome::viewer::picture_comparison_test {
namespace {

struct PixelValue {
  int x, y;
  float value;
};
#include "picture_reference.inc"

constexpr int kWidth = 64, kHeight = 48;

/// Returns an image of make_picture_reference.py.
LinearPicture picture(bool is_reference) {
  LinearPicture made{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      Rgb color;
      for (int c = 0; c < 3; ++c) {
        double value = ((5 * x + 3 * y + 40 * c) % 256) / 255.;
        if (!is_reference) {
          const int noise = (7919 * x + 104729 * y + 1299721 * c) % 61 - 30;
          value = std::clamp(value + noise / 300., 0., 1.);
        }
        const int left = is_reference ? 20 : 21;
        constexpr double kSquare[] = {0.9, 0.2, 0.1};
        if (x >= left && x < left + 16 && y >= 12 && y < 28) value = kSquare[c];
        color[c] = static_cast<float>(value);
      }
      made.pixels.push_back(color);
    }
  }
  return made;
}

LinearPicture bright(LinearPicture made) {
  for (Rgb& color : made.pixels) color = 20.f * (color * color);
  return made;
}

Image image_of(const LinearPicture& from) {
  Image image{from.width, from.height, {"R", "G", "B"}, {}};
  for (const Rgb& color : from.pixels) {
    image.data.insert(image.data.end(), {color.x, color.y, color.z});
  }
  return image;
}

template <size_t N>
void expect_values(const std::vector<float>& values, const PixelValue (&expected)[N]) {
  ASSERT_EQ(values.size(), size_t{kWidth} * kHeight);
  // The white point of the reference implementation differs by 1e-4, and its sums are in another
  // order.
  for (const PixelValue& e : expected) {
    EXPECT_NEAR(values[static_cast<size_t>(e.y) * kWidth + e.x], e.value, 1e-3f)
        << e.x << ", " << e.y;
  }
}

TEST(Flip, AgreesWithItsAuthors) {
  const auto values = Flip(picture(true)).differences(picture(false));
  EXPECT_NEAR(mean_of(values), kLdrFlip, 2e-4);
  expect_values(values, kLdrFlipAt);
}

TEST(Flip, AgreesOfRadianceWithItsAuthors) {
  const LinearPicture reference = bright(picture(true));
  const Exposures exposures = flip_exposures(reference);
  EXPECT_NEAR(exposures.first, kFirstExposure, 1e-3);
  EXPECT_NEAR(exposures.last, kLastExposure, 1e-3);
  EXPECT_EQ(exposures.count, kExposures);
  const auto values = hdr_flip(reference, bright(picture(false)));
  EXPECT_NEAR(mean_of(values), kHdrFlip, 2e-4);
  expect_values(values, kHdrFlipAt);
}

TEST(Flip, IsNothingOfEqualsAndMuchOfOpposites) {
  const LinearPicture a = picture(true);
  for (const float value : Flip(a).differences(a)) EXPECT_EQ(value, 0);
  LinearPicture black = a, white = a;
  for (Rgb& color : black.pixels) color = Rgb(0);
  for (Rgb& color : white.pixels) color = Rgb(1);
  for (const float value : Flip(black).differences(white)) EXPECT_GT(value, 0.9f);
}

TEST(Reference, RelMseMatchesTheValidation) {
  Image reference = image_of(bright(picture(true)));
  Image other = image_of(bright(picture(false)));
  other.at(7, 5, 1) = std::numeric_limits<float>::quiet_NaN();
  other.at(11, 30, 0) = -std::numeric_limits<float>::infinity();
  const PictureErrors errors = Reference(reference, "a.exr").errors_of(other);
  EXPECT_NEAR(errors.rel_mse / kRelMse, 1, 1e-6);
  EXPECT_NEAR(errors.largest / kLargest, 1, 1e-6);
  EXPECT_EQ(errors.left_out, 2u);

  // The image has variances, which are subtracted.
  Image noisy{kWidth, kHeight, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, {}};
  for (int i = 0; i < kWidth * kHeight; ++i) {
    for (const float factor : {1.f, 0.01f}) {
      for (int c = 0; c < 3; ++c) noisy.data.push_back(factor * reference.data[3 * i + c]);
    }
  }
  const PictureErrors fewer = Reference(noisy, "a.exr").errors_of(other);
  EXPECT_NEAR(fewer.rel_mse / kRelMseOfNoisy, 1, 1e-6);
  EXPECT_NEAR(fewer.largest / kLargestOfNoisy, 1, 1e-6);
}

TEST(Reference, ShowsDifferences) {
  const Image reference{2, 1, {"R", "G", "B"}, {1, 2, 3, 0, 0, 0}};
  const Image other{2, 1, {"R", "G", "B", "A"}, {2, 2, 1, 1, 0, 0.5f, 0, 1}};
  const Reference against(reference, "a.exr");
  const Image difference = against.difference_of(other, Difference::kSigned, {});
  EXPECT_EQ(difference.data, (std::vector<float>{1, 0, -2, 0, 0.5f, 0}));
  const Image relative = against.difference_of(other, Difference::kRelative, {});
  EXPECT_NEAR(relative.data[0], 1 / std::sqrt(1.01), 1e-6);
  EXPECT_NEAR(relative.data[4], 0.5 / std::sqrt(0.01), 1e-5);
  double sum = 0;
  for (const float d : relative.data) sum += d * d;
  EXPECT_NEAR(sum / 6, against.errors_of(other).rel_mse, 1e-5);
  const Image flip = against.difference_of(other, Difference::kFlip, {});
  EXPECT_EQ(flip.channels, std::vector<std::string>{"Y"});
  EXPECT_GT(flip.data[0], 0.05f);
  const auto bright_reference = image_of(bright(picture(true)));
  expect_values(Reference(bright_reference, "a.exr")
                    .difference_of(image_of(bright(picture(false))), Difference::kHdrFlip, {})
                    .data,
                kHdrFlipAt);
  // Grey images, and a black reference.
  const Image grey{2, 1, {"Y"}, {0, 0}}, lighter{2, 1, {"Y"}, {0.1f, 0}};
  EXPECT_NEAR(Reference(grey, "a.exr").errors_of(lighter).rel_mse, 0.005, 1e-8);
}

TEST(Reference, ErrorsGiveTheReason) {
  const test::TemporaryFolder folder;
  const std::string missing = folder.path("missing.exr");
  test::expect_error([&] { Reference reference(missing); }, missing, "");
  const Image depth{2, 1, {"depth"}, {1, 2}}, grey{2, 1, {"Y"}, {1, 2}};
  test::expect_error([&] { Reference(depth, "d.exr"); }, "d.exr", "R, G and B");
  const Reference reference({2, 1, {"R", "G", "B"}, {1, 2, 3, 4, 5, 6}}, "r.exr");
  test::expect_error(
      [&] {
        reference.errors_of({1, 1, {"R", "G", "B"}, {1, 2, 3}});
      },
      "r.exr", "1x1");
  test::expect_error([&] { reference.errors_of(grey); }, "r.exr", "channels");
}

TEST(SplitView, HasAPartOfEach) {
  const Image black{4, 2, {"Y"}, std::vector<float>(8, 0.f)};
  const Image white{4, 2, {"Y"}, std::vector<float>(8, 1.f)};
  const ToneMapper mapper{Tone()};
  for (const int split : {-1, 0, 1, 3, 4, 9}) {
    const auto shown = split_view(mapper, black, white, split);
    for (int i = 0; i < 8; ++i) EXPECT_EQ(shown[4 * i], i % 4 < split ? 0 : 255) << split;
  }
}

TEST(Display, ShowsTheImageBesideItsReference) {
  const Image black{4, 2, {"R", "G", "B"}, std::vector<float>(24, 0.f)};
  const Image white{4, 2, {"R", "G", "B"}, std::vector<float>(24, 1.f)};
  Display display;
  display.reference = std::make_shared<Reference>(white, "white.exr");
  const auto row = [&](const Image& picture) {
    std::vector<uint8_t> rgba;
    display.map(picture, rgba);
    std::vector<int> reds;
    for (int x = 0; x < picture.width; ++x) reds.push_back(rgba[4 * x]);
    return reds;
  };
  EXPECT_EQ(row(black), (std::vector{0, 0, 0, 0}));
  display.shown = Shown::kReference;
  EXPECT_EQ(row(black), (std::vector{255, 255, 255, 255}));
  display.shown = Shown::kSplit;
  display.split = 0.25f;
  EXPECT_EQ(row(black), (std::vector{0, 255, 255, 255}));
  // A preview of another size.
  const Image small{2, 1, {"R", "G", "B"}, std::vector<float>(6, 0.f)};
  display.split = 0.5f;
  EXPECT_EQ(row(small), (std::vector{0, 255}));
  display.shown = Shown::kDifference;
  EXPECT_EQ(row(black), (std::vector{0, 0, 0, 0}));  // no difference has been computed
  const Comparison comparison = compare(black, *display.reference, Difference::kSigned, {});
  EXPECT_EQ(comparison.fault, "");
  EXPECT_GT(comparison.flip, 0.9);
  display.difference = comparison.difference;
  display.difference_tone = tone_of(Difference::kSigned, 1);
  EXPECT_EQ(row(black)[0], signed_map()[0][0]);
  EXPECT_EQ(row(small), (std::vector{0, 0}));
  EXPECT_NE(compare(small, *display.reference, Difference::kSigned, {}).fault, "");

  const Image steps{4, 2, {"Y"}, {0, 1, 2, 3, 4, 5, 6, 7}};
  EXPECT_EQ(resampled(steps, 2, 1).data, (std::vector<float>{5, 7}));
  EXPECT_EQ(resampled(steps, 4, 2).data, steps.data);
}

/// A sky above a floor, half of which is behind a wall.
constexpr const char* kScene = R"(<scene version="3.0.0">
  <integrator type="clustered"><integer name="cut_size" value="60"/>
    <integer name="light_samples" value="2000"/><integer name="max_depth" value="3"/></integrator>
  <sensor type="perspective"><transform name="to_world">
      <lookat origin="0,1,3.5" target="0,.2,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
  </sensor>
  <emitter type="constant"/>
  <emitter type="spot"><transform name="to_world">
    <lookat origin="-.8,1,.5" target="1,1.2,-.5" up="0,1,0"/></transform></emitter>
  <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform></shape>
  <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="-90"/>
    <translate x="1" y="1"/></transform></shape>
</scene>)";

TEST(Inspector, ShowsWhereSamplesGoByEachImportance) {
  SceneEditor editor(kScene, "room.xml", LoadOptions{}, test::registry());
  const Sensor& sensor = *editor.scene()->sensors()[0];
  for (const char* importance : {"joint", "luminance", "brdf", "product"}) {
    const InspectedPixel found = inspect_pixel(editor, sensor, 2, {20.7f, 22.2f}, importance);
    ASSERT_EQ(found.fault, "") << importance;
    EXPECT_EQ(found.pixel, Vec2(20, 22));
    ASSERT_EQ(found.sets.size(), 2u) << importance;
    size_t lines = 0;
    for (const InspectedSet& set : found.sets) {
      const bool distant = set.report.is_distant;
      EXPECT_EQ(set.report.is_learned, importance == std::string("product"));
      // product sampling uses cut_size only as an approximate number
      EXPECT_TRUE(set.report.is_learned || set.report.clusters.size() == 60);
      EXPECT_TRUE(!distant || set.picture.width == 1024);
      ASSERT_TRUE(set.marks.point.has_value());
      // The point is within the filter's radius of the pixel.
      EXPECT_NEAR(set.marks.point->x, 20.5f, 2.5f);
      EXPECT_NEAR(set.marks.point->y, 22.5f, 2.5f);
      lines += set.marks.lines.size();
      EXPECT_EQ(set.marks.edges.empty(), distant);
    }
    EXPECT_GT(lines, 10u) << importance;
  }
  // The upper corner shows the sky.
  EXPECT_NE(inspect_pixel(editor, sensor, 2, {1, 1}, "joint").fault, "");
}

}  // namespace
}  // namespace kinome::viewer::picture_comparison_test

/// Tests splats: light that is added to a film apart from the samples of its pixels.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kinome/film_noise.h"
#include "support/render.h"

namespace kinome::test::splat_test {
namespace {

std::shared_ptr<Film> film_with(const std::string& filter, int width, int height,
                                const std::string& more = "") {
  return make<Film>("<film type=\"hdrfilm\"><integer name=\"width\" value=\"" +
                    std::to_string(width) + "\"/><integer name=\"height\" value=\"" +
                    std::to_string(height) + "\"/>" + more + "<rfilter type=\"" + filter +
                    "\"/></film>");
}

class EveryFilter : public testing::TestWithParam<const char*> {};

/// The sum of the image is the light of the splats. A Gaussian at whole-pixel steps sums to its
/// integral only in the mean over positions in the pixel. Midpoints of 16 x 16 positions have an
/// error of at most 1e-3 (a tent's kinks: 1/16²/4).
TEST_P(EveryFilter, KeepsTheSum) {
  const auto film = film_with(GetParam(), 11, 9);
  film->prepare({{}});
  FilmTile tile = film->make_tile({0, 0, 1, 1});  // splats may be outside the tile
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const Vec2 place((static_cast<float>(i % kSteps) + 0.5f) / kSteps,
                     (static_cast<float>(i / kSteps) + 0.5f) / kSteps);
    tile.add_splat(Vec2(5, 4) + place, Rgb(1, 2, 4));
  }
  tile.add_light_paths(kSteps * kSteps);
  film->commit(tile);
  const Image image = film->develop();
  double sum[3] = {};
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 11; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y, c);
    }
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 1 << c, 1e-3 * (1 << c));
}

/// Splats give the same image as weighted means of samples, up to the film's edges. This holds with
/// and without the border that the filter reaches. Splats outside the sampled region are ignored.
/// Pixels at an edge get light from only one side. The light increases to the right, so that errors
/// there are visible.
TEST_P(EveryFilter, SplatsGiveTheImageOfSamples) {
  for (const char* border : {"true", "false"}) {
    const std::string more = std::string(R"(<integer name="crop_offset_x" value="2"/>)"
                                         R"(<integer name="crop_width" value="4"/>)"
                                         R"(<boolean name="sample_border" value=")") +
                             border + "\"/>";
    const auto splatted = film_with(GetParam(), 7, 5, more);
    const auto sampled = film_with(GetParam(), 7, 5, more);
    splatted->prepare({{}});
    sampled->prepare({{}});
    const Rect reach = splatted->reach();
    const Rect within = splatted->sampled();
    constexpr int kSteps = 8;
    FilmTile splats = splatted->make_tile({2, 0, 6, 5});
    FilmTile samples = sampled->make_tile(within);
    for (int y = reach.y0 * kSteps; y < reach.y1 * kSteps; ++y) {
      for (int x = reach.x0 * kSteps; x < reach.x1 * kSteps; ++x) {
        const Vec2 p((static_cast<float>(x) + 0.5f) / kSteps,
                     (static_cast<float>(y) + 0.5f) / kSteps);
        const float light = 4 + p.x;
        const float values[3] = {light, 2 * light, 3};
        splats.add_splat(p, {values[0], values[1], values[2]});
        const bool is_sampled = x >= within.x0 * kSteps && x < within.x1 * kSteps &&
                                y >= within.y0 * kSteps && y < within.y1 * kSteps;
        if (is_sampled) samples.add(p, values);
      }
    }
    splats.add_light_paths(kSteps * kSteps);
    splatted->commit(splats);
    sampled->commit(samples);
    const Image image = splatted->develop(), expected = sampled->develop();
    ASSERT_EQ(image.width, 4);
    // Error of the midpoint rule: a tent's kinks cost up to 1/8²/4 of the value, a Gaussian's end
    // less.
    for (size_t i = 0; i < image.data.size(); ++i) {
      EXPECT_NEAR(image.data[i], expected.data[i], 0.004f * expected.data[i]) << border << i;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Splat, EveryFilter, testing::Values("box", "tent", "gaussian"));

TEST(Splat, IsAddedToMeansOfSamples) {
  const auto film = film_with("box", 3, 2);
  for (int round = 0; round < 2; ++round) {  // prepare() clears the first round
    film->prepare({{}});
    FilmTile tile = film->make_tile({0, 0, 3, 2});
    tile.add({1.2f, 0.5f}, std::vector<float>{1, 2, 3});
    tile.add({1.7f, 0.5f}, std::vector<float>{3, 2, 1});
    tile.add_splat({1.5f, 0.1f}, Rgb(10, 20, 30));
    tile.add_splat({1.9f, 0.9f}, Rgb(10, 20, 30));
    tile.add_splat({2.f, 1.f}, Rgb(1, 1, 1));
    tile.add_light_paths(4);
    film->commit(tile);
    const Image image = film->develop();
    EXPECT_EQ(image.at(1, 0, 0), 2 + 5);
    EXPECT_EQ(image.at(1, 0, 1), 2 + 10);
    EXPECT_EQ(image.at(1, 0, 2), 2 + 15);
    EXPECT_EQ(image.at(2, 1, 0), 0.25f);
    EXPECT_EQ(image.at(0, 0, 0), 0);
  }
}

/// The numbers of light paths of all lanes are added; each lane has its own splats.
TEST(Splat, LanesShareTheirPaths) {
  const auto film = film_with("box", 1, 1);
  film->prepare({{}}, 2);
  for (uint32_t lane = 0; lane < 2; ++lane) {
    film->set_lane(lane);
    FilmTile tile = film->make_tile({0, 0, 1, 1});
    tile.add_splat({0.5f, 0.5f}, Rgb(lane == 0 ? 12.f : 4.f));
    tile.add_light_paths(2);
    tile.add_light_paths(lane == 0 ? 1 : 0);
    film->commit(tile);
  }
  EXPECT_EQ(film->develop().at(0, 0, 0), 16.f / 5);
  EXPECT_EQ(film->lane_color(0, 0)->x, 4);
  EXPECT_EQ(film->lane_color(0, 1)->x, 2);
  // Variance of the mean over paths: lanes of 3 and 2 paths deviate by 12 - 3 m and 4 - 2 m, over
  // 5.
  EXPECT_NEAR(film_noise(*film).image.data[0], 2 * (0.48 * 0.48 + 0.48 * 0.48), 1e-6);
}

TEST(Splat, CountsInLuminanceAndLeavesAlpha) {
  const auto grey = film_with("box", 1, 1, R"(<string name="pixel_format" value="luminance"/>)");
  const auto alpha = film_with("box", 1, 1, R"(<string name="pixel_format" value="rgba"/>)");
  for (const auto& film : {grey, alpha}) {
    film->prepare({{}});
    FilmTile tile = film->make_tile({0, 0, 1, 1});
    tile.add_splat({0.5f, 0.5f}, Rgb(1, 2, 3));
    film->commit(tile);
  }
  EXPECT_NEAR(grey->develop().data[0], luminance(Rgb(1, 2, 3)), 1e-6f);
  EXPECT_EQ(alpha->develop().data, (std::vector<float>{1, 2, 3, 0}));
}

TEST(Splat, IgnoresDistantSplatsAndCountsNonFiniteOnes) {
  const auto film = film_with("gaussian", 4, 4);
  film->prepare({{}});
  FilmTile tile = film->make_tile({0, 0, 4, 4});
  for (const float x : {-3.f, 7.f, 1e9f, -1e30f}) tile.add_splat({x, 1}, Rgb(1.f));
  EXPECT_EQ(tile.non_finite(), 0u);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  tile.add_splat({1, 1}, Rgb(1, kNan, 1));
  tile.add_splat({1, 1}, Rgb(kInfinity, 1, 1));
  tile.add_splat({kNan, 1}, Rgb(1.f));
  film->commit(tile);
  EXPECT_EQ(film->non_finite(), 3u);
  for (const float value : film->develop().data) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace kinome::test::splat_test

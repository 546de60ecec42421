#include "kinome/film.h"
#include "kinome/film_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/film_values.h"
#include "kinome/color.h"
#include "kinome/sampler.h"
#include "support/film_xml.h"

/// Tests crops, layers and invalid samples of films.
namespace kinome::test::film_samples_test {
namespace {

using namespace film_values;

TEST(Film, CropIsAWindowOfTheFullFilm) {
  const auto film = make_film(film_size(40, 30) + "<integer name=\"crop_offset_x\" value=\"7\"/>" +
                              "<integer name=\"crop_offset_y\" value=\"9\"/>" +
                              "<integer name=\"crop_width\" value=\"11\"/>" +
                              "<integer name=\"crop_height\" value=\"5\"/><rfilter type=\"box\"/>");
  EXPECT_EQ(film->width(), 40);
  EXPECT_EQ(film->crop().x0, 7);
  EXPECT_EQ(film->crop().y1, 14);
  film->prepare({{}});
  FilmTile tile = film->make_tile({0, 0, 40, 30});
  fill(tile, 1, [](int x, int y) {
    return std::vector<float>{static_cast<float>(x), static_cast<float>(y), 1.f};
  });
  film->commit(tile);
  const Image image = film->develop();
  ASSERT_EQ(image.width, 11);
  ASSERT_EQ(image.height, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 11; ++x) {
      EXPECT_EQ(image.at(x, y, 0), static_cast<float>(x + 7));
      EXPECT_EQ(image.at(x, y, 1), static_cast<float>(y + 9));
    }
  }
}

TEST(Film, LayersHaveWeightsOfTheirOwn) {
  const auto film =
      make_film(film_size(8, 8) + text("pixel_format", "rgba") + "<rfilter type=\"box\"/>");
  film->prepare({{"depth", "albedo.R"}, {"n.X"}});
  EXPECT_EQ(film->channels(),
            (std::vector<std::string>{"R", "G", "B", "A", "depth", "albedo.R", "n.X"}));
  EXPECT_EQ(film->value_count(0), 6);
  EXPECT_EQ(film->value_count(1), 1);
  FilmTile first = film->make_tile({0, 0, 8, 8}, 0);
  fill(first, 2, [](int, int) { return std::vector<float>{1, 2, 3, 0.5f, 10, 20}; });
  FilmTile second = film->make_tile({0, 0, 8, 8}, 1);
  fill(second, 5, [](int, int) { return std::vector<float>{-7}; });
  film->commit(first);
  film->commit(second);
  const Image image = film->develop();
  const float expected[] = {1, 2, 3, 0.5f, 10, 20, -7};
  for (int c = 0; c < 7; ++c) EXPECT_EQ(image.at(3, 4, c), expected[c]);
  EXPECT_THROW(first.add({1, 1}, std::vector<float>{1, 2, 3}), std::logic_error);
}

/// Tests powers of values, of colour channels and of XYZ, for single samples, blocks of samples,
/// and finished pixels. The film stores alpha because a channel shows it.
TEST(Film, TakesTheMeanOfPowers) {
  using Channel = FilmChannel;
  const auto film = make_film(film_size(8, 8) + "<rfilter type=\"gaussian\"/>");
  film->prepare({{"depth"}, {}}, {{"d", 0, 0},
                                  {"d2", 0, 0, 2},
                                  {"A", 1, Channel::kA},
                                  {"g4", 1, Channel::kG, 4},
                                  {"z", 1, Channel::kZ},
                                  {"z2", 1, Channel::kZ, 2}});
  EXPECT_TRUE(film->has_alpha());
  EXPECT_EQ(film->value_count(0), 5);
  EXPECT_TRUE(film->has_powers(0));
  const FilmLayers second(*film, 1);
  EXPECT_EQ(film->value_count(0), 4);
  const Rgb c(1, 2, 3);
  const std::vector<float> values{c.x, c.y, c.z, 0.5f}, none(4, 0.f);
  FilmTile tile = film->make_tile({0, 0, 8, 8});
  fill(tile, 2, [&](int, int) { return std::span(values); });
  fill(tile, 2, [&](int, int) { return std::span(none); });
  EXPECT_THROW(tile.add_sums(1, 1, values, 1), std::logic_error);
  film->commit(tile);
  const Image image = film->develop();
  const double z = xyz(glm::dvec3(c)).z;
  EXPECT_EQ(image.channels,
            (std::vector<std::string>{"R", "G", "B", "d", "d2", "A", "g4", "z", "z2"}));
  const double expected[] = {0, 0, 0, 0, 0, 0.25, 8, z / 2, z * z / 2};
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(image.at(4, 4, i), expected[i], 1e-6) << i;
}

TEST(Film, LuminanceIsComputedFromTheColour) {
  const auto film = make_film(film_size(4, 4) + text("pixel_format", "luminance_alpha") +
                              "<rfilter type=\"box\"/>");
  film->prepare({{"extra"}});
  EXPECT_EQ(film->channels(), (std::vector<std::string>{"Y", "A", "extra"}));
  EXPECT_EQ(film->value_count(0), 5);
  FilmTile tile = film->make_tile({0, 0, 4, 4});
  fill(tile, 1, [](int, int) { return std::vector<float>{1, 2, 4, 0.25f, 9}; });
  film->commit(tile);
  const Image image = film->develop();
  EXPECT_NEAR(image.at(2, 2, 0), luminance({1, 2, 4}), 1e-6f);
  EXPECT_EQ(image.at(2, 2, 1), 0.25f);
  EXPECT_EQ(image.at(2, 2, 2), 9.f);
}

TEST(Film, NonFiniteSamplesAreCountedAndDropped) {
  const auto film = make_film(film_size(4, 4) + "<rfilter type=\"box\"/>");
  film->prepare({{}});
  FilmTile tile = film->make_tile({0, 0, 4, 4});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  tile.add({1.5f, 1.5f}, std::vector<float>{1, 1, 1});
  tile.add({1.5f, 1.5f}, std::vector<float>{nan, 1, 1});
  tile.add({1.5f, 1.5f}, std::vector<float>{1, 1, -kInfinity});
  tile.add({nan, 1.5f}, std::vector<float>{1, 1, 1});
  tile.add({1e30f, 1.5f}, std::vector<float>{1, 1, 1});
  EXPECT_EQ(tile.non_finite(), 4u);
  film->commit(tile);
  EXPECT_EQ(film->non_finite(), 4u);
  const Image image = film->develop();
  EXPECT_EQ(image.at(1, 1, 0), 1.f);
  for (const float v : image.data) EXPECT_TRUE(std::isfinite(v));
  film->prepare({{}});
  EXPECT_EQ(film->non_finite(), 0u);
}

/// Finished pixels ignore the filter. Two values of one pixel are averaged.
TEST(Film, FinishedPixelsKeepTheirValue) {
  for (const char* filter : {"box", "gaussian"}) {
    const auto film = make_film(
        film_size(6, 4) +
        "<integer name=\"crop_offset_x\" value=\"1\"/><integer name=\"crop_width\" value=\"5\"/>" +
        "<rfilter type=\"" + filter + "\"/>");
    film->prepare({{}});
    FilmTile tile = film->make_tile({1, 0, 6, 4});
    tile.add_pixel(1, 0, std::vector<float>{1, 2, 3});
    tile.add_pixel(3, 2, std::vector<float>{4, 5, 6});
    tile.add_pixel(3, 2, std::vector<float>{6, 7, 8});
    tile.add_pixel(4, 1, std::vector<float>{1, 2, 3}, 3);
    tile.add_pixel(4, 1, std::vector<float>{5, 6, 7}, 1);
    tile.add_pixel(5, 3, std::vector<float>{-1, 0, 1e30f});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    tile.add_pixel(2, 2, std::vector<float>{1, nan, 1});
    tile.add_pixel(2, 2, std::vector<float>{std::numeric_limits<float>::infinity(), 1, 1});
    for (const auto& [x, y] : {std::pair(0, 0), {-1, 2}, {6, 1}, {2, 4}, {2, -1}, {1000, 1000}}) {
      tile.add_pixel(x, y, std::vector<float>{9, 9, 9});  // outside the tile
    }
    EXPECT_THROW(tile.add_pixel(1, 1, std::vector<float>{1, 1}), std::logic_error);
    film->commit(tile);
    EXPECT_EQ(film->non_finite(), 2u);
    const Image image = film->develop();
    ASSERT_EQ(image.width, 5);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        Rgb expected(0.f);
        if (x == 0 && y == 0) expected = {1, 2, 3};
        if (x == 2 && y == 2) expected = {5, 6, 7};
        if (x == 3 && y == 1) expected = {2, 3, 4};
        if (x == 4 && y == 3) expected = {-1, 0, 1e30f};
        for (int c = 0; c < 3; ++c) EXPECT_EQ(image.at(x, y, c), expected[c]) << x << " " << y;
      }
    }
  }
}

TEST(Film, SamplesOutsideAndEmptyTilesDoNothing) {
  const auto film = make_film(film_size(8, 8));
  film->prepare({{}});
  FilmTile outside = film->make_tile({-40, -40, -10, -10});
  outside.add({-20, -20}, std::vector<float>{1, 1, 1});
  film->commit(outside);
  FilmTile border = film->make_tile({-2, -2, 0, 0});
  border.add({-0.25f, -0.25f}, std::vector<float>{1, 1, 1});
  film->commit(border);
  const Image image = film->develop();
  EXPECT_EQ(image.at(0, 0, 0), 1.f) << "a border sample within the filter's reach counts";
  EXPECT_EQ(image.at(2, 2, 0), 0.f);
}

/// Gaps are pixels without samples, as in an interrupted render. A layer that has only light paths
/// has no gaps.
TEST(Film, ReportsItsGaps) {
  const auto film = make_film(film_size(8, 4) + "<rfilter type=\"box\"/>");
  film->prepare({{}, {"depth"}});
  const auto count = [&](int layer) {
    const std::vector<bool> gaps = film->gaps(layer);
    return std::count(gaps.begin(), gaps.end(), true);
  };
  EXPECT_EQ(count(0), 32);
  FilmTile paths = film->make_tile({0, 0, 8, 4});
  paths.add_light_paths(10);
  film->commit(paths);
  EXPECT_EQ(count(0), 0);
  EXPECT_EQ(count(1), 32);
  FilmTile colors = film->make_tile({0, 0, 4, 4});
  fill(colors, 1, [](int, int) { return std::array{0.f, 0.f, 0.f}; });
  film->commit(colors);
  EXPECT_EQ(count(0), 16);
  const std::vector<bool> gaps = film->gaps(0);
  for (size_t p = 0; p < gaps.size(); ++p) EXPECT_EQ(gaps[p], p % 8 >= 4) << p;
}

}  // namespace
}  // namespace kinome::test::film_samples_test

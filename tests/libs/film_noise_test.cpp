// Tests of the variance of an image, estimated from the lanes of a film.

#include <gtest/gtest.h>

#include <random>

#include "support/film_xml.h"
#include "kinome/film_noise.h"

namespace kinome::test::film_noise_test {
namespace {

/// Lanes are filled one by one. The image is their weighted mean, and its variance is the variance
/// of this mean.
TEST(FilmNoise, LanesGiveTheImageAndItsVariance) {
  const auto film = make_film(film_size(2, 1) +
                              R"(<string name="pixel_format" value="rgba"/><rfilter type="box"/>)");
  film->prepare({{"extra"}, {"other"}}, 3);
  ASSERT_EQ(film->lanes(), 3u);
  const float values[3] = {1, 2, 6};
  for (uint32_t lane = 0; lane < 3; ++lane) {
    film->set_lane(lane);
    FilmTile tile = film->make_tile({0, 0, 2, 1}), other = film->make_tile({0, 0, 2, 1}, 1);
    const float v = values[lane];
    tile.add_pixel(0, 0, std::vector<float>{v, 2 * v, 0, 1, v}, 2);
    if (lane == 1) tile.add_pixel(1, 0, std::vector<float>{5, 5, 5, 0, 5}, 0.5f);
    other.add_pixel(0, 0, std::vector<float>{v}, lane == 0 ? 3.f : 1.f);
    film->commit(tile);
    film->commit(other);
  }
  const Image image = film->develop();
  ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A", "extra", "other"}));
  const std::vector<float> expected = {3, 6, 0, 1, 3, 11.f / 5, 5, 5, 5, 0, 5, 0};
  EXPECT_EQ(image.data, expected);
  const FilmNoise noise = film_noise(*film);
  ASSERT_EQ(noise.image.channels,
            (std::vector<std::string>{"variance.R", "variance.G", "variance.B", "tile_variance.R",
                                      "tile_variance.G", "tile_variance.B"}));
  // (2² + 1² + 3²) / (3 x 2). The pixel with one lane has no variance, so that the tile and the
  // image have that of the other pixel.
  const double variances[3] = {7. / 3, 28. / 3, 0};
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(noise.image.at(0, 0, c), static_cast<float>(variances[c]));
    EXPECT_EQ(noise.image.at(1, 0, c), kInfinity);
    for (const int x : {0, 1}) {
      EXPECT_FLOAT_EQ(noise.image.at(x, 0, 3 + c), static_cast<float>(variances[c]));
    }
    EXPECT_NEAR(noise.variance_of_mean.at(c), variances[c], 1e-12);
  }
  EXPECT_EQ(noise.renders, 3u);
  EXPECT_FALSE(film->lane_color(1, 0));
  EXPECT_EQ(*film->lane_color(0, 2), Rgb(6, 12, 0));
  film->prepare({{}});
  EXPECT_EQ(film->lanes(), 1u);
}

/// All pixels of a lane share their noise. The variance of tiles and of the image is that of each
/// pixel. The pixels' variances alone would give 1/256 of it. The last tiles are narrower.
TEST(FilmNoise, TilesIncludeNoiseThatPixelsShare) {
  const auto film =
      make_film(film_size(20, 18) +
                R"(<string name="pixel_format" value="luminance"/><rfilter type="box"/>)");
  film->prepare({{}}, 4);
  for (uint32_t lane = 0; lane < 4; ++lane) {
    film->set_lane(lane);
    FilmTile tile = film->make_tile({0, 0, 20, 18});
    for (int i = 0; i < 360; ++i) {
      // Two parts with opposite noise. It cancels out in tiles with as many pixels of both.
      const float v = static_cast<float>(lane) * (i / 20 < 8 ? 1.f : -1.f);
      tile.add_pixel(i % 20, i / 20, std::vector<float>{v, v, v});
    }
    film->commit(tile);
  }
  const FilmNoise noise = film_noise(*film);
  ASSERT_EQ(noise.image.channels, (std::vector<std::string>{"variance.Y", "tile_variance.Y"}));
  // Lanes of 0, 1, 2, 3: 5 / (4 x 3).
  for (int i = 0; i < 360; ++i) {
    EXPECT_NEAR(noise.image.at(i % 20, i / 20, 0), 5. / 12, 1e-6);
    EXPECT_NEAR(noise.image.at(i % 20, i / 20, 1), i / 20 < 16 ? 0 : 5. / 12, 1e-6);
  }
  EXPECT_NEAR(noise.variance_of_mean.at(0), 5. / 12 / 81, 1e-6);  // 8 rows against 10
}

/// A filter spreads each sample over several pixels. Here each lane has one sample, 1 or -1, at
/// each pixel's centre, so that the expected variance of the tile is known.
TEST(FilmNoise, TilesIncludeNoiseThatTheFilterSpreads) {
  const auto film = make_film(film_size(16, 16) + R"(<rfilter type="gaussian"/>)");
  constexpr uint32_t kLanes = 400;
  film->prepare({{}}, kLanes);
  std::mt19937 random(1);
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    film->set_lane(lane);
    FilmTile tile = film->make_tile({0, 0, 16, 16});
    for (int i = 0; i < 256; ++i) {
      const float v = random() % 2 == 0 ? 1.f : -1.f;
      tile.add({static_cast<float>(i % 16) + 0.5f, static_cast<float>(i / 16) + 0.5f},
               std::vector<float>{v, v, v});
    }
    film->commit(tile);
  }
  // Along an axis, w_px is the weight of sample x in pixel p. Sums over both axes are products.
  double of_tile = 0, of_pixels = 0;
  std::vector<double> shares(16, 0.);
  for (int p = 0; p < 16; ++p) {
    double sum = 0, squares = 0;
    for (int x = 0; x < 16; ++x) sum += film->filter().eval(static_cast<float>(p - x));
    for (int x = 0; x < 16; ++x) {
      const double w = film->filter().eval(static_cast<float>(p - x)) / sum;
      shares[x] += w;
      squares += w * w;
    }
    of_pixels += squares;
  }
  for (const double share : shares) of_tile += share * share;
  const FilmNoise noise = film_noise(*film);
  double pixels = 0;
  for (int i = 0; i < 256; ++i) pixels += noise.image.at(i % 16, i / 16, 0);
  // A variance from 400 lanes has a relative error of 1/14, and over 256 pixels 1/100. The
  // tolerances are 5 times that.
  EXPECT_NEAR(pixels / (of_pixels * of_pixels / kLanes), 1, 0.05);
  EXPECT_NEAR(256. * 256 * noise.image.at(0, 0, 3) / (of_tile * of_tile / kLanes), 1, 0.35);
  EXPECT_GT(of_tile * of_tile, 2 * of_pixels * of_pixels);  // or the test would be meaningless
}

}  // namespace
}  // namespace kinome::test::film_noise_test

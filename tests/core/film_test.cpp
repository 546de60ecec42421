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

namespace kinome::test::film_test {
namespace {

using namespace film_values;

class EveryFilter : public testing::TestWithParam<const char*> {};

TEST_P(EveryFilter, ConstantStaysConstant) {
  const auto film = make_film(film_size(70, 41) + "<rfilter type=\"" + GetParam() + "\"/>");
  film->prepare({{}});
  // Tiles whose borders overlap, some narrower than the filter.
  for (const Rect& r : {Rect{0, 0, 32, 41}, Rect{32, 0, 33, 41}, Rect{33, 0, 70, 41}}) {
    FilmTile tile = film->make_tile(r);
    fill(tile, 3, [](int, int) { return std::vector<float>{0.25f, 3.f, 1e4f}; });
    film->commit(tile);
  }
  const Image image = film->develop();
  ASSERT_EQ(image.width, 70);
  ASSERT_EQ(image.height, 41);
  ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
  // Sums are exact to double precision; their quotient is rounded to float.
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      ASSERT_NEAR(image.at(x, y, 0), 0.25f, 0.25f * 2e-7f);
      ASSERT_NEAR(image.at(x, y, 1), 3.f, 3.f * 2e-7f);
      ASSERT_NEAR(image.at(x, y, 2), 1e4f, 1e4f * 2e-7f);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Film, EveryFilter, testing::Values("box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"));

/// Expects the same pixel values everywhere in a film of a few pixels.
void expect_everywhere(const Film& film, const std::vector<float>& values, const char* what) {
  const Image image = film.develop();
  for (size_t i = 0; i < image.data.size(); ++i) {
    const float value = values[i % values.size()];
    ASSERT_NEAR(image.data[i], value, 2e-7f * value) << what << ", value " << i;
  }
}

/// These values are no sums of powers of two. In single precision, each of a few thousand samples
/// would add the same rounding error.
TEST(Film, ManySamplesKeepTheirMean) {
  const std::vector<float> values{0.1f, 1.f / 3, 7e4f};
  const Rect all{0, 0, 2, 2};
  for (const char* filter : {"box", "gaussian"}) {
    const auto film = make_film(film_size(2, 2) + "<rfilter type=\"" + filter + "\"/>");
    film->prepare({{}});
    FilmTile tile = film->make_tile(all);
    fill(tile, 1 << 16, [&](int, int) { return std::span(values); });
    film->commit(tile);
    expect_everywhere(*film, values, "one pass");

    film->prepare({{}});
    for (int pass = 0; pass < 1 << 14; ++pass) {
      FilmTile part = film->make_tile(all);
      fill(part, 4, [&](int, int) { return std::span(values); });
      film->commit(part);
    }
    expect_everywhere(*film, values, "passes");
  }
}

/// Weights in single precision would stop growing at 2^24.
TEST(Film, WeightsGrowBeyondSinglePrecision) {
  const auto film = make_film(film_size(1, 1) + "<rfilter type=\"box\"/>");
  film->prepare({{}});
  const std::vector<float> dark(3, 0.f), bright(3, 1.f);
  FilmTile tile = film->make_tile({0, 0, 1, 1});
  constexpr int kSamples = 1 << 24;
  for (int i = 0; i < kSamples; ++i) tile.add({0.5f, 0.5f}, dark);
  for (int i = 0; i < kSamples / 2; ++i) tile.add_pixel(0, 0, bright);
  film->commit(tile);
  expect_everywhere(*film, std::vector<float>(3, 1.f / 3), "weights");
}

TEST(Film, BoxCountsASampleForThePixelThatHoldsIt) {
  const auto film = make_film(film_size(4096, 3) + "<rfilter type=\"box\"/>");
  const struct {
    float x;
    int pixel;
  } cases[] = {{0.f, 0},
               {0.5f, 0},
               {std::nextafter(1.f, 0.f), 0},
               {1.f, 1},
               {1.5f, 1},
               {4095.f, 4095},
               {std::nextafter(4096.f, 0.f), 4095},
               {2047.f, 2047},
               {std::nextafter(2047.f, 0.f), 2046}};
  for (const auto& c : cases) {
    film->prepare({{}});
    FilmTile tile = film->make_tile({0, 0, 4096, 3});
    tile.add({c.x, 1.25f}, std::vector<float>{1.f, 2.f, 3.f});
    film->commit(tile);
    const Image image = film->develop();
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < image.width; ++x) {
        ASSERT_EQ(image.at(x, y, 1), x == c.pixel && y == 1 ? 2.f : 0.f) << c.x << " " << x;
      }
    }
  }
}

TEST(Film, PositionsStayInsideTheirPixel) {
  for (const int x : {0, 1, 31, 1023, 4095, 65535, -1, -2, -32}) {
    const Vec2 low = film_position(x, 7, Vec2(0.f));
    const Vec2 high = film_position(x, 7, Vec2(kOneMinusEpsilon));
    EXPECT_EQ(std::floor(low.x), static_cast<float>(x));
    EXPECT_EQ(std::floor(high.x), static_cast<float>(x));
    EXPECT_GT(high.x, static_cast<float>(x) + 0.99f);
    EXPECT_EQ(std::floor(high.y), 7.f);
  }
}

TEST(Film, SingleSampleReachesAsFarAsItsFilterWithItsWeights) {
  const auto film = make_film(film_size(12, 12) + "<rfilter type=\"gaussian\"/>");
  const ReconstructionFilter& filter = film->filter();
  EXPECT_EQ(filter.radius(), 2.f);
  film->prepare({{}});
  const Vec2 p(5.3f, 6.9f);
  FilmTile tile = film->make_tile({0, 0, 12, 12});
  // A second sample of value 0 at each centre makes the weights of the first visible.
  tile.add(p, std::vector<float>{1.f, 1.f, 1.f});
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) {
      FilmTile other = film->make_tile({x, y, x + 1, y + 1});
      other.add({x + 0.5f, y + 0.5f}, std::vector<float>{0.f, 0.f, 0.f});
      film->commit(other);
    }
  }
  film->commit(tile);
  const Image image = film->develop();
  // Sum of the zeros' weights, which is equal for all pixels that have all their neighbours.
  double zeros = 0;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      zeros += double{filter.eval(static_cast<float>(i))} * filter.eval(static_cast<float>(j));
    }
  }
  for (int y = 2; y < 10; ++y) {
    for (int x = 2; x < 10; ++x) {
      const double w = double{filter.eval(x + 0.5f - p.x)} * filter.eval(y + 0.5f - p.y);
      EXPECT_NEAR(image.at(x, y, 0), w / (w + zeros), 1e-5) << x << " " << y;
      const bool reached = std::abs(x + 0.5f - p.x) < 2 && std::abs(y + 0.5f - p.y) < 2;
      EXPECT_EQ(image.at(x, y, 0) > 0, reached) << x << " " << y;
    }
  }
}

TEST(Film, FilterValuesAreMitsubas) {
  const auto eval = [](const char* xml, float x) {
    return make<ReconstructionFilter>(xml)->eval(x);
  };
  // Mitsuba 3.9.1: mi.load_dict({"type": "gaussian"}).eval(x). It evaluates a polynomial that was
  // fitted to the formula, which differs by up to 4.2e-4 (at 0).
  EXPECT_NEAR(eval("<rfilter type=\"gaussian\"/>", 0.f), 0.99924713f, 5e-4f);
  EXPECT_NEAR(eval("<rfilter type=\"gaussian\"/>", 0.25f), 0.88216674f, 5e-4f);
  EXPECT_NEAR(eval("<rfilter type=\"gaussian\"/>", 0.5f), 0.60642302f, 5e-4f);
  EXPECT_NEAR(eval("<rfilter type=\"gaussian\"/>", 1.f), 0.13496049f, 5e-4f);
  EXPECT_NEAR(eval("<rfilter type=\"gaussian\"/>", 1.5f), 0.01075821f, 5e-4f);
  EXPECT_EQ(eval("<rfilter type=\"gaussian\"/>", 2.f), 0.f);
  EXPECT_EQ(eval("<rfilter type=\"tent\"/>", 0.25f), 0.75f);
  EXPECT_EQ(eval("<rfilter type=\"tent\"/>", -0.5f), 0.5f);
  EXPECT_EQ(eval("<rfilter type=\"tent\"/>", 1.f), 0.f);
  const auto wide = make<ReconstructionFilter>(
      "<rfilter type=\"tent\"><float name=\"radius\" value=\"2\"/></rfilter>");
  EXPECT_EQ(wide->radius(), 2.f);
  EXPECT_EQ(wide->eval(1.f), 0.5f);
  EXPECT_EQ(make<ReconstructionFilter>("<rfilter type=\"box\"/>")->radius(), 0.5f);
  // By rounding, a pixel's only sample may be on its edge, where even the narrowest filter must be
  // positive.
  for (const char* narrowest :
       {"<rfilter type=\"tent\"><float name=\"radius\" value=\"0.51\"/></rfilter>",
        "<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"0.13\"/></rfilter>"}) {
    EXPECT_GT(make<ReconstructionFilter>(narrowest)->eval(0.5f), 1e-5f) << narrowest;
  }
}

/// Mitsuba 3.9.1: mi.load_dict({"type": "mitchell"}).eval(x), and so on.
TEST(Film, NegativeFilterValuesAreMitsubas) {
  static constexpr float kPlaces[] = {0,    .25f,  .5f,   .75f, 1,    1.25f,
                                      1.5f, 1.75f, 1.99f, 2,    2.5f, 2.99f};
  struct Case {
    const char* xml;
    float values[std::size(kPlaces)];
  };
  const Case cases[] = {
      {"<rfilter type=\"mitchell\"/>",
       {.888889f, .782118f, .534722f, .256076f, .055556f, -.023437f, -.034722f, -.014757f, -3.3e-5f,
        0, 0, 0}},
      {"<rfilter type=\"mitchell\"><float name=\"B\" value=\".2\"/>"
       "<float name=\"C\" value=\".5\"/></rfilter>",
       {.933333f, .820833f, .558333f, .258333f, .033334f, -.05625f, -.058333f, -.022916f, -4.9e-5f,
        0, 0, 0}},
      {"<rfilter type=\"catmullrom\"/>",
       {1, .867188f, .5625f, .226562f, 0, -.070312f, -.0625f, -.023438f, -4.9e-5f, 0, 0, 0}},
      {"<rfilter type=\"lanczos\"/>",
       {1, .890067f, .607927f, .27019f, 0, -.132871f, -.135095f, -.067791f, -.0021f, 0, .024317f,
        1.1e-5f}},
      {"<rfilter type=\"lanczos\"><integer name=\"lobes\" value=\"2\"/></rfilter>",
       {1, .877354f, .573159f, .235347f, 0, -.084725f, -.063684f, -.017905f, -2.5e-5f, 0, 0, 0}},
  };
  for (const Case& one : cases) {
    const auto filter = make<ReconstructionFilter>(one.xml);
    for (size_t i = 0; i < std::size(kPlaces); ++i) {
      EXPECT_NEAR(filter->eval(kPlaces[i]), one.values[i], 3e-6f) << one.xml << kPlaces[i];
      EXPECT_EQ(filter->eval(-kPlaces[i]), filter->eval(kPlaces[i])) << one.xml << kPlaces[i];
    }
    EXPECT_EQ(filter->eval(filter->radius() + 1e-4f), 0.f) << one.xml;
  }
}

}  // namespace
}  // namespace kinome::test::film_test

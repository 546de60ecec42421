#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "product_scenes.h"
#include "render/product/product_cases.h"

/// Tests properties of product sampling other than its expectation: bits, alpha, limits and
/// extremes.
namespace kinome::test::product_properties_test {
namespace {

using namespace product_cases;

/// Objects that most pixels' pilot rays miss: their light must not depend on the pilot.
TEST(Product, ThinObjectsAreNotLost) {
  Arrangement s;
  s.film = integer("width", 6) + integer("height", 6) + "<rfilter type=\"box\"/>";
  s.light = constant_xml("1 .8 .6");
  s.shapes.clear();
  for (int i = 0; i < 12; ++i) {
    s.shapes += "<shape type=\"sphere\"><point name=\"center\" x=\"" +
                std::to_string(.31 * i - 1.7) + "\" y=\"" + std::to_string(.17 * (i % 7)) +
                "\" z=\"0\"/><float name=\"radius\" value=\".12\"/>" + kGrey + "</shape>";
  }
  s.direct_samples = 256;
  s.finds = 0.2;
  expect_unbiased(s, 256, 6);
}

/// Compares the mean of many cheap renders with one long one, pixel by pixel: without a pilot, with
/// one for each that probes some of the pixels, and with one that probes all.
TEST(Product, ManyCheapRendersAreOneGoodOne) {
  Arrangement s;
  s.direct_samples = 64;
  for (const std::string& material : {kGrey, bsdf("roughplastic", number("alpha", .2))}) {
    s.shapes = shapes_xml(material);
    const auto direct = estimate_tiles(*direct_scene(s), kRenders, 1, 5000);
    for (const double rays : {3., 8., 12.}) {
      if (rays == 8 && material != kGrey) continue;
      s.rays = rays;
      expect_equal(estimate_tiles(*product_scene(s), 256, 1), direct, kAlpha,
                   std::to_string(rays) + " rays");
    }
  }
}

TEST(Product, SeveralPassesAreUnbiased) {
  Arrangement s;
  s.rays = 700;
  s.film = integer("width", 8) + integer("height", 6) + "<rfilter type=\"box\"/>";
  s.direct_samples = 256;
  expect_unbiased(s, 24, 2);
}

TEST(Product, SameBitsAtAnyThreadCountAndTileOrder) {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .1)));
  s.film = integer("width", 70) + integer("height", 40) + "<rfilter type=\"gaussian\"/>";
  for (const double rays : {4., s.rays}) {
    s.rays = rays;
    const auto scene = product_scene(s);
    const auto image = [&](unsigned threads, uint64_t order) {
      RenderContext context({.threads = threads, .seed = 3, .tile_order_seed = order});
      return render(*scene, *scene->sensors()[0], context).data;
    };
    const auto expected = image(1, 0);
    EXPECT_EQ(image(1, 7), expected) << rays;
    EXPECT_EQ(image(2, 0), expected) << rays;
    EXPECT_EQ(image(3, 5), expected) << rays;
  }
}

TEST(Product, AlphaIsTheShareOfSurfaces) {
  Arrangement s;
  s.film += "<string name=\"pixel_format\" value=\"rgba\"/>";
  s.shapes = R"(<shape type="sphere"><point name="center" x="0" y=".7" z="0"/>
      <float name="radius" value=".7"/>)" +
             kGrey + "</shape>";
  for (const bool hide : {false, true}) {
    s.hide = hide;
    const auto product = product_scene(s), direct = direct_scene(s);
    std::vector<Moments> a(16 * 12), b(16 * 12);
    for (uint64_t seed = 1; seed <= kRenders; ++seed) {
      const Image x = render_scene(*product, seed), y = render_scene(*direct, 500 + seed);
      ASSERT_EQ(x.channels.size(), 4u);
      for (int i = 0; i < 16 * 12; ++i) {
        a[i].add(x.at(i % 16, i / 16, 3));
        b[i].add(y.at(i % 16, i / 16, 3));
      }
    }
    Estimate sum_a, sum_b;
    for (int i = 0; i < 16 * 12; ++i) {
      if (b[i].mean() == 0 || b[i].mean() == 1) {
        EXPECT_NEAR(a[i].mean(), b[i].mean(), 0.02);
      }
      sum_a.mean += a[i].mean();
      sum_b.mean += b[i].mean();
      sum_a.variance_of_mean += a[i].variance_of_mean();
      sum_b.variance_of_mean += b[i].variance_of_mean();
    }
    const Verdict verdict = z_test({sum_a}, {sum_b}, kAlpha);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

/// Images that are known exactly.
TEST(Product, NothingToShadeIsExact) {
  Arrangement s;
  s.shapes.clear();
  s.hide = false;
  s.light = constant_xml("1 .5 .25");
  const auto expect_all = [&](const Rgb& colour) {
    const Image image = render_scene(*product_scene(s), 1);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(x, y, c), colour[c], 1e-6);
      }
    }
  };
  expect_all({1, .5f, .25f});  // every pixel background
  s.hide = true;
  expect_all(Rgb(0.f));
  s.shapes = shapes_xml(kGrey);
  s.light = constant_xml("0");
  expect_all(Rgb(0.f));
  s.light = map_xml("black", 8, 5, [](int, int) { return Rgb(0.f); });
  expect_all(Rgb(0.f));
  // Inside a closed box: all light is occluded, and the budget is kept.
  s.light = constant_xml("1");
  s.shapes = "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"20\"/></transform>" +
             bsdf("twosided", kGrey) + "</shape>";
  expect_all(Rgb(0.f));
  const auto scene = product_scene(s);
  RenderContext context({.threads = 1});
  render(*scene, *scene->sensors()[0], context);
  const auto& rays = context.job.stats().counters.rays;
  EXPECT_LE(std::accumulate(rays.begin(), rays.end(), 0.), 1.1 * s.rays * 16 * 12);
}

TEST(Product, RefusesNumbersOfCellsThatMakeNoSense) {
  for (const int cells : {0, -1, 1 << 21}) {
    Arrangement s;
    s.parameters = integer("cut_size", cells);
    try {
      product_scene(s);
      ADD_FAILURE() << cells;
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("cut_size"), std::string::npos) << text;
      EXPECT_NE(text.find(std::to_string(cells)), std::string::npos) << text;
    }
  }
}

/// Tiles, blocks and maps of the minimum size, in all combinations, with light and without.
TEST(Product, OnePixelOfOneTexel) {
  for (const std::string& light : {constant_xml("0"), constant_xml("1"),
                                   map_xml("one", 1, 1, [](int, int) { return Rgb(1); })}) {
    for (const double rays : {1., 12., 3000.}) {
      Arrangement s;
      s.film = integer("width", 1) + integer("height", 1) + "<rfilter type=\"box\"/>";
      s.light = light;
      s.rays = rays;
      for (const int cells : {1, 512}) {
        s.parameters = integer("cut_size", cells);
        const Image image = render_scene(*product_scene(s), 1);
        for (const float v : image.data) {
          EXPECT_TRUE(std::isfinite(v));
          EXPECT_GE(v, 0);
          if (rays > 1) {
            EXPECT_EQ(v > 0, light != constant_xml("0")) << light << rays;
          }
        }
      }
    }
  }
}

/// 268 million pixels, of which a few are requested.
TEST(Product, CropsOfAHugeFilmTakeLittle) {
  Arrangement s;
  s.film = integer("width", 16384) + integer("height", 16384) + integer("crop_offset_x", 8190) +
           integer("crop_offset_y", 9001) + integer("crop_width", 9) + integer("crop_height", 7);
  s.shapes = shapes_xml(metal(.2));
  const auto scene = product_scene(s);
  RenderContext context({.threads = 1, .seed = 4});
  const Image image = render(*scene, *scene->sensors()[0], context);
  EXPECT_EQ(std::pair(image.width, image.height), std::pair(9, 7));
  const auto& rays = context.job.stats().counters.rays;
  EXPECT_LE(std::accumulate(rays.begin(), rays.end(), 0.), 1.5 * s.rays * 9 * 7);
}

TEST(Product, IsFiniteOnExtremes) {
  for (const std::string& material :
       {metal(.0001), metal(1), bsdf("phong", number("exponent", 1e6)),
        bsdf("ward", number("alpha_u", .0005) + number("alpha_v", 1)),
        bsdf("roughplastic", number("alpha", .001))}) {
    for (const std::string& light :
         {sun_xml(), constant_xml("1e-30"), constant_xml("1e30"),
          map_xml("range", 8, 5, [](int x, int y) { return Rgb((x + y) % 3 ? 1e-20f : 1e12f); })}) {
      Arrangement s;
      s.shapes = shapes_xml(material);
      s.light = light;
      const auto scene = product_scene(s);
      RenderContext context({.threads = 1, .seed = 4});
      const Image image = render(*scene, *scene->sensors()[0], context);
      EXPECT_EQ(context.job.stats().non_finite_samples, 0u) << material << light;
      for (const float v : image.data) EXPECT_TRUE(std::isfinite(v));
    }
  }
}

}  // namespace
}  // namespace kinome::test::product_properties_test

// `clustered` with importance = product has the expectation of `direct`: z-tests over tiles of
// pixels and over the image, for each kind of material, emitter, camera, film and budget. Each
// z-test has a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <numeric>

#include "product_scenes.h"
#include "kinome/image_files.h"

namespace kinome::test::product_test {
namespace {

struct Case {
  const char* name;
  Arrangement setup;
};
Case with(const char* name, const std::function<void(Arrangement&)>& change) {
  Case c{name, {}};
  change(c.setup);
  return c;
}
Case of_material(const char* name, const std::string& material, int times = 1) {
  return with(name, [&](Arrangement& s) {
    s.shapes = shapes_xml(material);
    s = often(s, times);
  });
}

/// Normals that are tilted by up to 40 degrees, texel by texel.
std::string normal_map(const std::string& nested) {
  const Vec3 normals[4] = {{.6f, 0, .8f}, {0, 0, 1}, {-.5f, -.3f, .8f}, {0, .6f, .8f}};
  Image image{8, 8, {"R", "G", "B"}, {}};
  for (int i = 0; i < 64; ++i) {
    const Vec3 colour = 0.5f * (glm::normalize(normals[(i + i / 8) % 4]) + 1.f);
    image.data.insert(image.data.end(), {colour.x, colour.y, colour.z});
  }
  const std::string path = folder().path("normals.exr");
  write_exr(path, image, ExrNumber::kFloat, {});
  return bsdf("normalmap",
              "<texture name=\"normalmap\" type=\"bitmap\"><string name=\"filename\" value=\"" +
                  path + "\"/><boolean name=\"raw\" value=\"true\"/></texture>" + nested);
}
class Unbiased : public testing::TestWithParam<Case> {};
TEST_P(Unbiased, AsDirectIs) {
  expect_unbiased(GetParam().setup);
}

std::vector<Case> materials() {
  return {
      of_material("Diffuse", kGrey),
      of_material("Textured", bsdf("diffuse", checkerboard("reflectance"))),
      of_material("Twosided", bsdf("twosided", kGrey)),
      of_material("Phong", bsdf("phong", number("exponent", 40))),
      of_material("WardAnisotropic", bsdf("ward", number("alpha_u", .05) + number("alpha_v", .3))),
      of_material("RoughPlastic", bsdf("roughplastic", number("alpha", .1))),
      of_material("RoughPlasticTextured",
                  bsdf("roughplastic", number("alpha", .3) + checkerboard("diffuse_reflectance"))),
      of_material("SharpMetal", metal(.02), 16),
      of_material("SharpestMetal", metal(.0005), 16),
      of_material("WideMetal", metal(.4)),
      of_material("Mirror", bsdf("conductor"), 16),
      of_material("Plastic", bsdf("plastic")),
      of_material("NormalMap", normal_map(kGrey)),
      of_material("NormalMapOnPlastic", normal_map(bsdf("roughplastic", number("alpha", .2)))),
      of_material("NormalMapOnMetal", normal_map(metal(.1)), 8),
      of_material("NormalMapOnBothSides", bsdf("twosided", normal_map(kGrey))),
      // BSDFs without a form for kernels are evaluated point by point.
      of_material("TwoNormalMaps", normal_map(normal_map(kGrey))),
      of_material("TwoNormalMapsOnMetal", normal_map(normal_map(metal(.1))), 8),
  };
}
INSTANTIATE_TEST_SUITE_P(Materials, Unbiased, testing::ValuesIn(materials()),
                         [](const auto& c) { return std::string(c.param.name); });

std::vector<Case> lights() {
  const auto light = [](const char* name, const std::string& xml) {
    return with(name, [&](Arrangement& s) { s.light = xml; });
  };
  const auto one_texel = [](int x, int y) {
    return x == 12 && y == 5 ? Rgb(500, 300, 100) : Rgb(0.f);
  };
  const auto pole = [](int x, int y) {
    return y == 0 && x == 5 ? Rgb(900, 700, 500) : Rgb(0.1f, 0.2f, 0.3f);
  };
  const auto coarse = [](int x, int y) {
    return Rgb(0.3f + 0.5f * static_cast<float>(x), 0.2f + static_cast<float>(y * y), 1);
  };
  // Little noise, so that small errors of candidates' weights are visible.
  Case gradient = light("GradientOnMetal", map_xml("gradient", 32, 17, [](int x, int y) {
                          return Rgb(0.1f + 0.05f * static_cast<float>(y)) *
                                 (x < 16 ? Rgb(1, 0.9f, 0.8f) : Rgb(0.7f, 0.8f, 0.9f));
                        }));
  gradient.setup.shapes =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1.2\"/>" + metal(.3) + "</shape>";
  gradient.setup.rays = 32;
  gradient.setup.direct_samples = 64;
  Case texel = light("TexelOnMetal", map_xml("texel", 32, 17, one_texel));
  texel.setup.shapes =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1.2\"/>" + metal(.05) + "</shape>";
  texel.setup.rays = 32;
  texel.setup.direct_samples = 512;  // little noise: small errors of densities are visible
  return {
      gradient,
      texel,
      light("Constant", constant_xml("1 .8 .6")),
      light("OneLitTexel", map_xml("texel", 32, 17, one_texel)),
      light("SunAtThePole", map_xml("pole", 16, 9, pole)),
      light("Turned", map_xml("turned", 32, 17, harsh,
                              "<rotate x=\"1\" angle=\"40\"/><rotate y=\"1\" angle=\"70\"/>")),
      light("Map1x1", map_xml("1x1", 1, 1, coarse)),
      light("Map1x7", map_xml("1x7", 1, 7, coarse)),
      light("Map2x2", map_xml("2x2", 2, 2, coarse)),
      light("Map5x1", map_xml("5x1", 5, 1, coarse)),
      light("Faint", constant_xml("1e-20")),
      light("Glaring", constant_xml("1e15")),
  };
}
INSTANTIATE_TEST_SUITE_P(Lights, Unbiased, testing::ValuesIn(lights()),
                         [](const auto& c) { return std::string(c.param.name); });

std::vector<Case> settings() {
  std::vector<Case> all;
  const auto parameter = [&](const char* name, const std::string& xml) {
    all.push_back(with(name, [&](Arrangement& s) { s.parameters = xml; }));
  };
  const auto rays = [&](const char* name, double count) {
    all.push_back(with(name, [&](Arrangement& s) {
      s.rays = count;
      s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .1)));
    }));
  };
  parameter("NoControlVariate", off("control_variate"));
  parameter("NoLearnedSigma", off("learned_sigma"));
  parameter("NotAdaptive", off("adaptive"));
  parameter("NotCheckedSigma", off("checked_sigma"));
  parameter("NotSmoothed", off("smooth_plan"));
  parameter("NoHorizonTerms", off("horizon_terms"));
  parameter("NoFewerCells", off("fewer_cells"));
  parameter("NoSharedCandidates", off("shared_candidates"));
  parameter("NothingLearned", off("control_variate") + off("learned_sigma") + off("adaptive"));
  parameter("OneCell", integer("cut_size", 1));
  parameter("FewCells", integer("cut_size", 20));
  parameter("ManyCells", integer("cut_size", 100000));
  rays("Rays2", 2);
  rays("Rays3", 3);
  rays("Rays6", 6);
  rays("Rays48", 48);
  all.push_back(with("Huge", [](Arrangement& s) { s.scale = 1e4; }));
  all.push_back(with("Tiny", [](Arrangement& s) { s.scale = 1e-4; }));
  for (Case& c : all) {
    if (c.setup.scale == 1) continue;
    // The whole world is scaled; shapes are defined in its units.
    const std::string scale = "<scale value=\"" + std::to_string(c.setup.scale) + "\"/>";
    const auto in = [&](const std::string& before) {
      return "<shape type=\"" + before + "\"><transform name=\"to_world\">";
    };
    const std::string end = scale + "</transform>" + kGrey + "</shape>";
    c.setup.shapes = in("sphere") + "<scale value=\".7\"/><translate y=\".7\"/>" + end +
                     in("rectangle") + "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/>" + end;
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Settings, Unbiased, testing::ValuesIn(settings()),
                         [](const auto& c) { return std::string(c.param.name); });

/// Films of direct are weighted means, whose bias falls with the number of samples.
std::vector<Case> cameras() {
  const auto film = [](const char* name, const std::string& xml, int samples = 16) {
    return with(name, [&](Arrangement& s) {
      s.film = xml;
      s.direct_samples = samples;
    });
  };
  const std::string size = integer("width", 16) + integer("height", 12);
  const std::string crop = integer("crop_offset_x", 5) + integer("crop_offset_y", 2) +
                           integer("crop_width", 9) + integer("crop_height", 7);
  const std::string border = "<boolean name=\"sample_border\" value=\"true\"/>";
  const auto filter = [](const char* type) {
    return "<rfilter type=\"" + std::string(type) + "\"/>";
  };
  std::vector<Case> all = {
      film("Gaussian", size + filter("gaussian"), 128),
      film("Tent", size + filter("tent"), 128),
      film("Mitchell", size + filter("mitchell"), 128),
      film("Lanczos", size + filter("lanczos"), 128),
      film("CropCatmullRom", size + crop + filter("catmullrom"), 128),
      film("Crop", size + crop + filter("box")),
      film("CropGaussian", size + crop + filter("gaussian"), 128),
      film("SmallCropGaussian",
           size + integer("crop_offset_x", 6) + integer("crop_offset_y", 5) +
               integer("crop_width", 3) + integer("crop_height", 2) +
               "<rfilter type=\"gaussian\">" + number("stddev", 1) + "</rfilter>",
           512),
      film("BorderGaussian", size + crop + border + filter("gaussian"), 128),
      film("OnePixel", integer("width", 1) + integer("height", 1) + filter("box"), 256),
      film("OnePixelGaussian", integer("width", 1) + integer("height", 1) + filter("gaussian"),
           4096),
      film("OnePixelLanczos", integer("width", 1) + integer("height", 1) + filter("lanczos"), 1024),
      film("TwoByOneLanczos", integer("width", 2) + integer("height", 1) + filter("lanczos"), 512),
      film("FiveByThree", integer("width", 5) + integer("height", 3) + filter("box"), 64),
      film("FiveByThreeOfFewRays",
           integer("width", 5) + integer("height", 3) + filter("box"), 64),
      film("Wide", integer("width", 61) + integer("height", 2) + filter("box")),
      film("Tall", integer("width", 2) + integer("height", 41) + filter("box")),
  };
  for (Case& c : all) {
    const std::string name = c.name;
    if (name == "OnePixelGaussian") {
      c.setup.light = constant_xml("1 .8 .6");  // little noise: positions of samples are visible
      c.setup.rays = 400;
    } else if (name == "FiveByThreeOfFewRays") {
      c.setup.rays = 6;  // the pilot probes squares that the border cuts
      c.setup = often(c.setup, 4);
    } else if (c.setup.film.find("\"width\" value=\"16") == std::string::npos ||
               name == "SmallCropGaussian") {
      c.setup.rays *= 16;  // few pixels: noise of direct is small there
    }
  }
  all.push_back(with("ThinLens", [](Arrangement& s) {
    s.sensor = "thinlens";
    s.optics += number("aperture_radius", .3) + number("focus_distance", 5);
  }));
  all.push_back(with("Orthographic", [](Arrangement& s) {
    s.sensor = "orthographic";
    s.optics = "";
  }));
  all.push_back(with("VisibleSky", [](Arrangement& s) {
    s.hide = false;
    s.light = constant_xml("1 .5 .25");
  }));
  return all;
}
INSTANTIATE_TEST_SUITE_P(Cameras, Unbiased, testing::ValuesIn(cameras()),
                         [](const auto& c) { return std::string(c.param.name); });

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
}  // namespace kinome::test::product_test

// `clustered` with importance = product has the expectation of `path` at any depth: z-tests over
// tiles of pixels and over the image, for each kind of emitter and material. Each z-test has a
// false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <algorithm>

#include "path_scenes.h"
#include "render/product/product_scenes.h"
#include "support/plugin_sets.h"

namespace kinome::test::deep_light_test {
namespace {

const std::string kLamp =
    shape_xml("rectangle",
              "<scale value=\".6\"/><rotate x=\"1\" angle=\"90\"/><translate x=\".3\" y=\"2.5\"/>",
              area_xml("6 5 4"));
const std::string kSpot =
    "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"30 25 20\"/>" +
    number("cutoff_angle", 25) + number("beam_width", 15) +
    "<transform name=\"to_world\"><lookat origin=\"2,3,2\" target=\".5,0,.3\" up=\"0,1,0\"/>"
    "</transform></emitter>";

struct Case {
  const char* name;
  std::string light;
  std::string material;
  int max_depth;
  std::string floor = "";  ///< above the floor of that material
  bool hide = true;        ///< hide_emitters
};

const std::string kStone =
    shape_xml("rectangle",
              "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\".01\"/>", kGrey);

const std::string kLargePlane = shape_xml(
    "rectangle", "<scale value=\"200\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"-.01\"/>",
    kGrey);

Arrangement setup_of(const Case& c) {
  Arrangement s;
  s.light = c.light;
  s.max_depth = c.max_depth;
  // Two stone walls around the shapes, close to one another and to the floor.
  s.shapes = shapes_xml(c.material) + c.floor +
             shape_xml("rectangle", "<scale value=\"4\"/><translate z=\"-1.6\"/>", kGrey) +
             shape_xml("rectangle",
                       "<scale value=\"4\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"-1.8\"/>",
                       diffuse_xml(".7 .3 .2"));
  s.rays = 48;
  s.direct_samples = 64;
  s.hide = c.hide;
  return s;
}

/// Most of the sky's light falls where the camera doesn't see it, so that light paths are split.
const std::string kPlain =
    shape_xml("rectangle",
              "<scale value=\"9\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"-.01\"/>", kGrey);

class DeepLight : public testing::TestWithParam<Case> {};
TEST_P(DeepLight, IsUnbiased) {
  expect_unbiased(setup_of(GetParam()));
}

const std::string kMirror = bsdf("twosided", bsdf("conductor"));
const std::string kPlastic = bsdf("twosided", bsdf("roughplastic", number("alpha", .2)));

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return info.param.name;
}
INSTANTIATE_TEST_SUITE_P(
    Cases, DeepLight,
    testing::Values(
        Case{"LampDepth4", kLamp, kGrey, 4}, Case{"LampDepth6", kLamp, kGrey, 6},
        Case{"LampAnyDepth", kLamp, kGrey, -1}, Case{"SkyDepth4", sun_xml(), kGrey, 4},
        Case{"SkyAnyDepth", sun_xml(), kGrey, -1},
        Case{"SkyOnLargePlane", constant_xml("1 .9 .8"), kGrey, -1, kPlain},
        Case{"SpotDepth4", kSpot, kGrey, 4},
        Case{"SpotAnyDepth", kSpot, kGrey, -1}, Case{"LampOnPlastic", kLamp, kPlastic, -1},
        Case{"FarPointAnyDepth", point_xml("150,400,250", "2e6 2e6 1e6"), kGrey, -1},
        Case{"SkyOnALargePlane", constant_xml("1 .9 .8"), kGrey, -1, kLargePlane},
        Case{"SpotOnPlastic", kSpot, kPlastic, 4}, Case{"LampOnMetal", kLamp, metal(.3), -1},
        Case{"LampOnNarrowMetal", kLamp, metal(.1), -1},
        Case{"SkyOnMirrors", constant_xml("1 .9 .8"), kMirror, -1},
        Case{"LampOnMirrors", kLamp, kMirror, 5},
        Case{"LampOnGlass", kLamp, bsdf("dielectric"), 8, kStone},
        Case{"SkyOnGlass", sun_xml(), bsdf("dielectric"), 8, kStone},
        Case{"LampOnSmoothPlastic", kLamp, bsdf("twosided", bsdf("plastic")), -1},
        Case{"SkyOnMaskedPlastic", constant_xml("1 .9 .8"),
             bsdf("mask", number("opacity", .5) + bsdf("twosided", bsdf("plastic"))), 3, kStone,
             false},
        Case{"LampOnGroundGlass", kLamp, bsdf("roughdielectric", number("alpha", .3)), 8, kStone},
        Case{"SkyAndSpotOnGroundGlass", constant_xml(".4 .5 .6") + kSpot,
             bsdf("roughdielectric", number("alpha", .2)), 2},
        Case{"EverythingOnAMask", kLamp + kSpot + constant_xml(".2 .2 .3"),
             bsdf("mask", number("opacity", .6) + bsdf("twosided", kGrey)), -1}),
    name_of);

/// With a lens, the fractions of light that glass shows are estimated at the lens's centre, which
/// is only approximate.
TEST(DeepLightGlass, IsUnbiasedThroughALens) {
  Arrangement s = setup_of({"", kLamp, bsdf("dielectric"), 8, kStone});
  s.sensor = "thinlens";
  s.optics += number("aperture_radius", .3) + number("focus_distance", 5);
  expect_unbiased(s);
}

/// Paths from the lamp find the light that glass focuses on the floor, where `path` hits the lamp
/// only by chance.
TEST(DeepLightGlass, IsFoundFromTheLamp) {
  Arrangement s = setup_of({"",
                            shape_xml("rectangle",
                                      "<scale value=\".1\"/><rotate x=\"1\" angle=\"90\"/>"
                                      "<translate y=\"4\" z=\"1\"/>",
                                      area_xml("200 200 200")),
                            kGrey, -1});
  s.shapes = kStone +
             "<shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"3\" z=\"1\"/>"
             "<float name=\"radius\" value=\".6\"/>" +
             bsdf("dielectric") + "</shape>";
  const auto noise = [](const std::vector<Estimate>& tiles) {
    double sum = 0;
    for (const Estimate& tile : tiles) {
      if (tile.mean > 0) sum += tile.variance_of_mean / (tile.mean * tile.mean);
    }
    return sum;
  };
  const double product = noise(estimate_tiles(*product_scene(s), 24, 4));
  const double path = noise(estimate_tiles(*direct_scene(s), 24, 4, 5000));
  EXPECT_LT(product, path / 4);
  s.direct_samples = 512;
  expect_unbiased(s);
}

/// Roulette ends paths earlier without changing the expectation.
TEST(DeepLightPaths, EndByRouletteUnbiased) {
  Arrangement s = setup_of({"", kLamp, kPlastic, -1});
  s.parameters = integer("rr_depth", 1);
  expect_unbiased(s);
}

/// Walls that absorb little: light bounces until roulette ends its paths. Seen from inside, every
/// point of a closed sphere that emits e and reflects rho has the radiance e / (1 - rho).
TEST(DeepLightPaths, FillAFurnace) {
  for (const double rho : {0.5, 0.9}) {
    const std::string grey = std::to_string(rho);
    const auto scene = scene_from(
        "<scene version=\"3.0.0\">" +
        integrator_xml("clustered", -1, kNoTrial + number("rays_per_pixel", 48)) +
        sensor_xml("perspective", look_at("0 0 0", "0 0 1", "0 1 0"), 4, 4) +
        "<shape type=\"sphere\"><boolean name=\"flip_normals\" value=\"true\"/>" +
        diffuse_xml(grey + " " + grey + " " + grey) + area_xml("1 1 1") + "</shape></scene>");
    const auto picture = estimate_pixels(*scene, 24);
    expect_equal(picture, std::vector<Estimate>(picture.size(), {1 / (1 - rho), 0}), 1e-4, grey);
  }
}

/// A lamp within a glass ball: only eye rays find its light, and a trial leaves the image to
/// `path`.
TEST(DeepLightPaths, MatchPathForLightThroughGlass) {
  const std::string glass =
      "<shape type=\"sphere\"><point name=\"center\" x=\".3\" y=\"2.5\" "
      "z=\"0\"/><float name=\"radius\" value=\"1.2\"/>" +
      bsdf("dielectric") + "</shape>";
  Arrangement s = setup_of({"", kLamp + glass, kGrey, -1, kStone});
  s.film = integer("width", 96) + integer("height", 72) + "<rfilter type=\"box\"/>";
  const auto scene = make_scene(s, integrator_xml("clustered", -1), 64);
  RenderContext context({.threads = 2, .seed = 6});
  render(*scene, *scene->sensors()[0], context);
  const auto& skipped = context.job.stats().skipped;
  EXPECT_TRUE(std::any_of(skipped.begin(), skipped.end(),
                          [](const Skipped& entry) { return entry.what == "product"; }));
}

/// The same bits with any number of threads.
TEST(DeepLightPaths, DoNotDependOnThreads) {
  const auto scene = product_scene(setup_of({"", kLamp + kSpot, kPlastic, -1}));
  EXPECT_EQ(render_scene(*scene, 7, 1).data, render_scene(*scene, 7, 3).data);
}

/// Every ball has its own BSDF, so that most blocks of paths are partly filled: unused SIMD lanes
/// must be ignored. Vectors of any width use the same random numbers, but not the same lanes.
TEST(DeepLightPaths, LeaveUnusedLanesOut) {
  std::string balls;
  for (int i = 0; i < 60; ++i) {
    const auto at = [](int k, double step) { return std::to_string(k * step - 1.2); };
    balls += "<shape type=\"sphere\"><point name=\"center\" x=\"" + at(i % 5, .6) + "\" y=\"" +
             at(i / 5 % 4, .7) + "\" z=\"" + at(i / 20, 1.1) + "\"/>" + number("radius", .28) +
             bsdf("dielectric") + "</shape>";
  }
  const std::string floor = shape_xml(
      "rectangle", "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"-1.6\"/>",
      kGrey);
  const std::string xml =
      "<scene version=\"3.0.0\">" +
      integrator_xml("clustered", 12, kNoTrial + number("rays_per_pixel", 192)) +
      sensor_xml("perspective", look_at("0 2.5 6", "0 0 0", "0 1 0"), 32, 32) +
      constant_xml("1 1 1") + balls + floor + "</scene>";
  const auto scene_for = [&](InstructionSet set) {
    return load_scene_from_string(xml, "balls.xml", {}, registry_of(set));
  };
  const std::vector<InstructionSet> sets = instruction_sets();
  const auto best = scene_for(sets.back());
  for (size_t i = 0; i + 1 < sets.size(); ++i) {
    const auto differences = estimate_differences(*scene_for(sets[i]), *best, 12, 32);
    expect_equal(differences, std::vector<Estimate>(differences.size(), {0, 0}), 1e-4,
                 to_string(sets[i]));
  }
}

}  // namespace
}  // namespace kinome::test::deep_light_test

/// Walks through media that are enclosed by glass, against paths without walks.
#include <gtest/gtest.h>

#include <cmath>

#include "volume_scenes.h"

namespace kinome::test::walks_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 15 z-tests

std::string glass_xml(float alpha) {
  return "<bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"" + std::to_string(alpha) +
         "\"/></bsdf>";
}
const std::string kSky = constant_xml("1 0.8 0.6");
const std::string kSun =
    "<emitter type=\"directional\"><vector name=\"direction\" value=\"0.5 0.2 -1\"/></emitter>";
const std::string kLamp =
    shape_xml("sphere", "<scale value=\"0.5\"/><translate z=\"3\" x=\"1\"/>", area_xml("6 5 4"));

/// A body of glass around `medium`. Without walks, a tiny shape beside it has the medium on its
/// outside, so that it isn't enclosed.
std::string body_xml(const std::string& shape, const std::string& boundary,
                     const std::string& medium, bool walks) {
  const auto reference = [](const char* side) {
    return "<ref name=\"" + std::string(side) + "\" id=\"inside\"/>";
  };
  std::string named = medium;
  named.replace(named.find(" name=\"interior\""), 16, " id=\"inside\"");
  return named + shape_xml(shape, "", boundary + reference("interior")) +
         shape_xml("sphere", "<scale value=\"0.0001\"/><translate x=\"2\"/>",
                   kBoundary + (walks ? "" : reference("exterior")));
}
std::unique_ptr<Scene> body_scene(const std::string& body, const std::string& light,
                                  int max_depth = -1, int side = 4) {
  return scene_from(body + light + integrator_xml("volpath", max_depth) +
                    parallel_view(0.9, side, 64));
}

struct Case {
  const char* name;
  const char* shape;
  float alpha;
  std::string medium;
  std::string light;
  int max_depth = -1;
};

TEST(Walks, AgreeWithPathsThatSampleEmitters) {
  const std::string wax = fog_xml("2 2 2", "0.8 0.8 0.8");
  const std::string skin = fog_xml("0.7 2 4", "0.9 0.8 0.5", phase_xml(0.4f));
  const std::vector<Case> cases = {
      {"sky", "sphere", 0.3f, wax, kSky},
      {"smooth", "cube", 0.05f, wax, kSky},
      {"lamp", "sphere", 0.3f, wax, kLamp},
      {"sun", "sphere", 0.3f, wax, kSun},
      {"coloured", "sphere", 0.3f, skin, kSky + kLamp},
      {"short", "sphere", 0.3f, wax, kSky, 4},
  };
  for (const Case& c : cases) {
    const auto estimates = [&](bool walks, uint64_t seed) {
      const std::string body = body_xml(c.shape, glass_xml(c.alpha), c.medium, walks);
      return estimate_pixels(*body_scene(body, c.light, c.max_depth), kRenders, seed);
    };
    expect_equal(estimates(true, 0), estimates(false, 1000), kAlpha, c.name);
  }
}

/// Light that enters through a hole is found, although few points sample it.
TEST(Walks, FindTheSunThroughAHole) {
  const std::string sun =
      "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 1\"/></emitter>";
  const auto estimates = [&](bool walks, uint64_t seed) {
    const std::string body =
        body_xml("rectangle", glass_xml(0.3f), fog_xml("0.3 0.3 0.3", "0.8 0.8 0.8"), walks);
    return estimate_pixels(*body_scene(body, sun), kRenders, seed);
  };
  const auto found = estimates(true, 0);
  expect_equal(found, estimates(false, 1000), kAlpha, "sun");
  EXPECT_GT(found.front().mean, 0.005);
}

/// Lamps inside of the body are sampled by all points.
TEST(Walks, SampleLampsInsideOfTheBody) {
  const std::string lamp = point_xml("0.2 0 0", "1 1 1");
  const std::string medium = fog_xml("1 1 1", "0.8 0.8 0.8");
  const auto estimates = [&](const std::string& body, uint64_t seed) {
    return estimate_pixels(*body_scene(body, lamp), kRenders, seed);
  };
  expect_equal(estimates(body_xml("sphere", glass_xml(0.3f), medium, true), 0),
               estimates(body_xml("sphere", glass_xml(0.3f), medium, false), 1000), kAlpha, "lamp");
}

/// Each channel of a coloured body is the image of a grey one.
TEST(Walks, ChannelsMatchGreyBodies) {
  const auto estimates = [](const std::string& extinction, const std::string& albedo,
                            uint64_t seed) {
    const std::string body = body_xml("sphere", glass_xml(0.3f), fog_xml(extinction, albedo), true);
    return estimate_pixels(*body_scene(body, constant_xml("1 1 1"), -1, 2), kRenders, seed);
  };
  const std::pair<const char*, const char*> greys[] = {
      {"1 1 1", "0.95 0.95 0.95"}, {"5 5 5", "0.9 0.9 0.9"}, {"20 20 20", "0.5 0.5 0.5"}};
  const auto coloured = estimates("1 5 20", "0.95 0.9 0.5", 0);
  for (int c = 0; c < 3; ++c) {
    const auto grey = estimates(greys[c].first, greys[c].second, 1000);
    const Verdict verdict = z_test(channel(coloured, c), channel(grey, c), kAlpha / 3);
    EXPECT_TRUE(verdict.passed) << "channel " << c << ": " << verdict.text;
  }
}

/// Bodies without absorption vanish in uniform light, also if light takes a hundred
/// collisions to cross them.
TEST(Walks, BodiesWithoutAbsorptionVanishInAnEvenLight) {
  for (const char* const extinction : {"1 1 1", "30 30 30"}) {
    const std::string body =
        body_xml("sphere", "<bsdf type=\"dielectric\"/>", fog_xml(extinction, "1 1 1"), true);
    expect_equal(estimate_pixels(*body_scene(body, constant_xml("1 1 1"), -1, 2), kRenders),
                 exactly(Rgb(1), 4), kAlpha, extinction);
  }
}

/// Light takes a thousand collisions to leave, and some of it a million.
TEST(Walks, LongWalksKeepTheirLight) {
  const std::string body =
      body_xml("sphere",
               "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1\"/><float "
               "name=\"ext_ior\" value=\"1\"/></bsdf>",
               fog_xml("1000 1000 1000", "1 1 1"), true);
  expect_equal(estimate_pixels(*body_scene(body, constant_xml("1 1 1"), -1, 2), kRenders),
               exactly(Rgb(1), 4), kAlpha, "long");
}

TEST(Walks, DoNotDependOnTheNumberOfThreads) {
  for (const char* const extinction : {"3 3 3", "1000000 3 0", "100000 100000 100000"}) {
    const std::string body =
        body_xml("sphere", glass_xml(0.3f), fog_xml(extinction, "0.9 0.9 0.9"), true);
    const auto scene = body_scene(body, kSky + kSun, -1, 24);
    const Image one = render_scene(*scene, 3, 1);
    EXPECT_EQ(one.data, render_scene(*scene, 3, 4).data) << extinction;
    for (const float value : one.data) ASSERT_TRUE(std::isfinite(value) && value >= 0);
  }
}

}  // namespace
}  // namespace kinome::test::walks_test

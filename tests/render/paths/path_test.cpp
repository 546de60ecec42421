/// `path` against `direct`, closed forms and itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "path_scenes.h"

namespace kinome::test::path_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 40 z-tests

std::vector<Estimate> estimate(const std::string& scene, uint64_t first_seed = 1) {
  return estimate_pixels(*scene_from(scene), kRenders, first_seed);
}

/// Objects of several materials on a floor.
std::string still_life() {
  return floor_xml(diffuse_xml("0.2 0.5 0.8")) +
         shape_xml("sphere", "<translate value=\"-1.1 1 0\"/>",
                   "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf>") +
         shape_xml("sphere", "<translate value=\"1.1 1 0\"/>", "<bsdf type=\"plastic\"/>");
}
std::string lights() {
  return shape_xml("rectangle",
                   "<scale value=\"0.7\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"4\"/>",
                   area_xml("9 5 2")) +
         point_xml("2 3 2", "3 2 6") + constant_xml("0.2 0.3 0.4");
}
std::string view(int side = 6, int samples = 16) {
  return sensor_xml("perspective", look_at("0 3 6", "0 0.8 0", "0 1 0"), side, samples);
}

TEST(Path, TwoEdgesAreDirectLight) {
  const std::string environment = constant_xml("0.2 0.3 0.4");
  for (const std::string& light : {environment, lights()}) {
    const std::string scene = still_life() + light + view();
    expect_equal(estimate(scene + integrator_xml("path", 2)), estimate(scene + direct_xml(), 50001),
                 kAlpha, light);
  }
}

/// Emission 1 and albedo 1/2 everywhere: each edge contributes half as much as the one before.
TEST(Path, ClosedFurnaceIsAGeometricSeries) {
  const std::string sphere =
      "<shape type=\"sphere\"><boolean name=\"flip_normals\" value=\"true\"/>" +
      diffuse_xml("0.5 0.8 0.2") + area_xml("1 1 1") + "</shape>" +
      sensor_xml("perspective", look_at("0.3 0.2 0.1", "1 0 0"), 2, 64);
  std::string cube;
  for (const char* const turn :
       {"x=\"1\" angle=\"0\"", "x=\"1\" angle=\"90\"", "x=\"1\" angle=\"180\"",
        "x=\"1\" angle=\"-90\"", "y=\"1\" angle=\"90\"", "y=\"1\" angle=\"-90\""}) {
    cube += shape_xml("rectangle", "<translate z=\"-1\"/><rotate " + std::string(turn) + "/>",
                      diffuse_xml("0.5 0.8 0.2") + area_xml("1 1 1"));
  }
  cube += sensor_xml("perspective", look_at("0.3 0.2 0.1", "1 0 0"), 2, 64);
  for (const std::string& room : {sphere, cube}) {
    Rgb expected(0.f), edge(1.f);
    for (const int depth : {1, 2, 3, 4, -1}) {
      expected += edge;
      edge *= Rgb(0.5, 0.8, 0.2);
      if (depth == -1) expected = 1.f / (1.f - Rgb(0.5, 0.8, 0.2));
      for (const int rr_depth : {1, 5}) {
        const auto rendered =
            estimate(room + integrator_xml("path", depth, rr_depth_xml(rr_depth)));
        if (depth == 1) {
          for (const Estimate& pixel : rendered) EXPECT_EQ(pixel.mean, 1);
          continue;
        }
        expect_equal(rendered, exactly(expected, 4), kAlpha,
                     "depth " + std::to_string(depth) + ", roulette " + std::to_string(rr_depth));
      }
    }
  }
}

TEST(Path, RouletteKeepsTheMean) {
  const std::string scene = room_xml() + point_xml("0.3 0.6 0.1", "1 1 1") + room_view(5, 32);
  expect_equal(estimate(scene + integrator_xml("path", 7, rr_depth_xml(1))),
               estimate(scene + integrator_xml("path", 7, rr_depth_xml(100)), 50001), kAlpha,
               "roulette at once, and never");
}

/// With hide_emitters, the camera looks through emitters at the surfaces behind them and at a black
/// sky, with their alpha (Mitsuba 3.9.1, path and direct). Mirrors still show emitters.
TEST(Path, HidesEmitters) {
  const std::string scene =
      shape_xml("rectangle", "<scale value=\"0.5\"/><translate z=\"2\"/>", area_xml("3 3 3")) +
      shape_xml("rectangle", "<scale value=\"0.5\"/><translate z=\"1\"/>",
                diffuse_xml("0.9") + area_xml("5 5 5")) +
      shape_xml("rectangle", "<scale value=\"0.8\"/>", diffuse_xml("0.5")) +
      sensor_xml("orthographic", "<scale value=\"1.5\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 9,
                 16, "independent", "rgba");
  for (const std::string& sky : {std::string(), constant_xml("1 1 1")}) {
    for (const std::string& type : {std::string("path"), std::string("direct")}) {
      const auto integrator = [&](const char* parameters) {
        return type == "path" ? integrator_xml(type, 2, parameters) : direct_xml(parameters);
      };
      const Image seen = render_scene(*scene_from(scene + sky + integrator("")));
      const Image hidden = render_scene(*scene_from(scene + sky + integrator(kHideEmitters)));
      EXPECT_EQ(seen.at(4, 4, 0), 3);
      EXPECT_EQ(seen.at(0, 0, 0), sky.empty() ? 0 : 1);
      EXPECT_EQ(hidden.at(0, 0, 0), 0);
      EXPECT_EQ(hidden.at(0, 0, 3), 0);
      EXPECT_EQ(hidden.at(4, 4, 3), 1);
      EXPECT_EQ(hidden.at(4, 4, 0) > 0, !sky.empty()) << "the lights' backs are black";
      EXPECT_LT(hidden.at(4, 4, 0), 0.5f);
    }
  }
  const std::string mirror =
      shape_xml("rectangle", "", "<bsdf type=\"conductor\"/>") +
      shape_xml("rectangle", "<rotate y=\"1\" angle=\"180\"/><translate z=\"3\"/>",
                area_xml("2 3 4")) +
      sensor_xml("orthographic", "<scale value=\"0.1\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 2,
                 4);
  const Image image = render_scene(*scene_from(mirror + integrator_xml("path", 2, kHideEmitters)));
  EXPECT_NEAR(image.at(0, 0, 1), 3, 1e-5f);
}

/// Returns the warnings of rendering.
std::string warning_of(const std::string& scene_xml) {
  const auto scene = scene_from(scene_xml);
  testing::internal::CaptureStderr();
  render_scene(*scene);
  return testing::internal::GetCapturedStderr();
}

TEST(WithoutEmitters, EveryIntegratorOfLightWarnsOnce) {
  const std::string scene = still_life() + view(4, 4);
  for (const char* type : {"direct", "path", "ptracer", "clustered", "groundtruth"}) {
    const bool has_depth = std::string(type) != "direct";
    const std::string integrator = has_depth ? integrator_xml(type, 2) : direct_xml();
    EXPECT_EQ(warning_of(scene + integrator),
              "kinome: warning: test.xml: the scene has no emitter: the image will be black\n")
        << type;
    EXPECT_EQ(warning_of(scene + constant_xml("1") + integrator), "") << type;
  }
  EXPECT_EQ(warning_of(scene + integrator_xml("clustered", 3)),
            "kinome: warning: test.xml: the scene has no emitter: the image will be black\n");
  EXPECT_EQ(warning_of(scene + "<integrator type=\"depth\"/>"), "");
}

/// Two mirrors face each other at 45 degrees to the view. The second one shows the sky.
TEST(Path, FollowsMirrors) {
  const std::string copper =
      "<bsdf type=\"conductor\"><rgb name=\"specular_reflectance\" value=\"0.5 0.25 1\"/></bsdf>";
  const std::string scene =
      shape_xml("rectangle", "<rotate y=\"1\" angle=\"45\"/>", copper) +
      shape_xml("rectangle", "<rotate y=\"1\" angle=\"-135\"/><translate x=\"4\"/>", copper) +
      constant_xml("1 2 3") +
      sensor_xml("orthographic", "<scale value=\"0.1\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 2,
                 4);
  const Rgb expected[] = {Rgb(0.f), Rgb(0.f), Rgb(0.25f * 1, 0.0625f * 2, 3)};
  for (const int depth : {1, 2, 3}) {
    const Image image = render_scene(*scene_from(scene + integrator_xml("path", depth)));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(1, 1, c), expected[depth - 1][c], 1e-5f);
  }
}

/// A mirror doesn't show a point light, but it shows surfaces that the light illuminates.
TEST(Path, SeesSurfacesLitByAPointInAMirror) {
  const std::string scene =
      shape_xml("rectangle", "", "<bsdf type=\"conductor\"/>") +
      shape_xml("rectangle",
                "<scale value=\"9\"/><rotate y=\"1\" angle=\"180\"/><translate z=\"6\"/>",
                diffuse_xml("0.5")) +
      point_xml("0 0 4", "1 2 3") +
      sensor_xml("orthographic", "<scale value=\"0.001\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 2,
                 4);
  for (const int depth : {2, 3, -1}) {
    const Image image = render_scene(*scene_from(scene + integrator_xml("path", depth)));
    for (int c = 0; c < 3; ++c) {
      const double direct = 0.5 / std::numbers::pi * (c + 1) / 4;
      if (depth == -1) {
        EXPECT_GE(image.at(0, 0, c), direct * (1 - 1e-4));
        continue;
      }
      EXPECT_NEAR(image.at(0, 0, c), depth == 2 ? 0 : direct, 1e-4 * direct);
    }
  }
}

TEST(Path, SameBitsAtAnyThreadCount) {
  for (const char* const sampler : kSamplers) {
    const auto scene = scene_from(
        still_life() + lights() + integrator_xml("path", 6, rr_depth_xml(2)) +
        sensor_xml("perspective", look_at("0 3 6", "0 0.8 0", "0 1 0"), 70, 4, sampler, "rgba"));
    const Image one = render_scene(*scene, 5, 1);
    EXPECT_EQ(one.data, render_scene(*scene, 5, 3).data) << sampler;
    EXPECT_NE(one.data, render_scene(*scene, 6, 3).data) << sampler;
  }
}

TEST(Path, SamplersAgree) {
  const auto render_with = [](const char* sampler, uint64_t seed) {
    return estimate(
        room_xml() + lights() + integrator_xml("path", 5) +
            sensor_xml("perspective", look_at("0 0 0.95", "0 0 -1", "0 1 0"), 4, 16, sampler),
        seed);
  };
  const auto independent = render_with("independent", 1);
  for (const char* const sampler : {"halton", "sobol", "stratified"}) {
    expect_equal(independent, render_with(sampler, 50001), kAlpha, sampler);
  }
}

TEST(Path, TracesNoUselessRays) {
  const auto counters_of = [](const std::string& scene) {
    const auto loaded = scene_from(scene);
    RenderContext context({});
    const Image image = render(*loaded, *loaded->sensors()[0], context);
    for (const float value : image.data) EXPECT_TRUE(std::isfinite(value));
    return context.job.stats().counters;
  };
  const uint64_t primaries = 6 * 6 * 16;
  const auto dark = counters_of(still_life() + view() + integrator_xml("path", -1));
  EXPECT_EQ(dark.rays, (std::array<uint64_t, kRayKindCount>{primaries, 0, 0, 0, 0}));
  // Only emitter samples find point lights: no ray leaves the last surface.
  const auto point = counters_of(floor_xml(diffuse_xml("0.5")) + point_xml("0 2 0", "1 1 1") +
                                 view() + integrator_xml("path", 2));
  EXPECT_EQ(point.rays, (std::array<uint64_t, kRayKindCount>{primaries, primaries, 0, 0, 0}));
  const auto emission = counters_of(still_life() + lights() + view() + integrator_xml("path", 1));
  EXPECT_EQ(emission.rays, (std::array<uint64_t, kRayKindCount>{primaries, 0, 0, 0, 0}));
}

std::string error_of(const std::string& integrator) {
  try {
    make<Integrator>(integrator);
  } catch (const Error& error) {
    EXPECT_NE(error.where().line, 0) << error.what();
    return error.what();
  }
  return "";
}

TEST(Path, ChecksItsParameters) {
  for (const char* const type : {"path", "ptracer"}) {
    for (const int good : {-1, 0, 1, 2, 2147483647}) {
      EXPECT_EQ(error_of(integrator_xml(type, good)), "");
    }
    for (const int bad : {-2, -1000}) {
      const std::string message = error_of(integrator_xml(type, bad));
      EXPECT_NE(message.find("'max_depth' must be -1 (no limit) or at least 0, got " +
                             std::to_string(bad)),
                std::string::npos)
          << message;
    }
    for (const int bad : {0, -1}) {
      EXPECT_NE(error_of(integrator_xml(type, 3, rr_depth_xml(bad)))
                    .find("'rr_depth' must be positive, got"),
                std::string::npos);
    }
    EXPECT_NE(error_of(integrator_xml(type, 3, "<float name=\"depth\" value=\"2\"/>")), "");
  }
}

/// A lamp in the centre of a sphere of reflectance rho: each bounce has rho times the light of the
/// one before, everywhere.
std::string furnace_xml(const std::string& rho) {
  return shape_xml("sphere", "<scale value=\"2\"/>",
                   "<boolean name=\"flip_normals\" value=\"true\"/>" + diffuse_xml(rho)) +
         point_xml("0 0 0", "3 2 1") +
         sensor_xml("perspective", look_at("0.7 0.2 0.1", "0 -1 0.3"), 6, 2, "independent", "rgba");
}
const std::string kJoint =
    "<string name=\"importance\" value=\"joint\"/><integer name=\"light_samples\" value=\"200\"/>";

/// Parameter that makes `clustered` render all images by product sampling, none by `path`.
const std::string kNoTrial = "<boolean name=\"trial\" value=\"false\"/>";

/// A depth beyond an integrator's maximum is valid, and 0 and 1 mean the same as for `path`.
TEST(MaxDepth, HasMitsubasMeaning) {
  struct Chooser {
    const char* type;
    std::string parameters;
  };
  const std::string lamp = shape_xml("sphere", "<scale value=\".3\"/>", area_xml("1 2 3"));
  const std::string scene = furnace_xml("0.5") + lamp;
  for (const Chooser& c : {Chooser{"clustered", kNoTrial}, Chooser{"clustered", kJoint},
                           Chooser{"groundtruth", kJoint.substr(kJoint.find("/>") + 2)}}) {
    SCOPED_TRACE(c.type + c.parameters);
    const auto picture = [&](int depth) {
      return render_scene(*scene_from(scene + integrator_xml(c.type, depth, c.parameters))).data;
    };
    const auto deepest = picture(-1);
    EXPECT_NE(picture(2), deepest);
    EXPECT_EQ(picture(2147483647), deepest);
    // Light points support only one bounce.
    const bool goes_on = c.parameters == kNoTrial;
    for (const int depth : {3, 4}) EXPECT_EQ(picture(depth) != deepest, goes_on) << depth;
    EXPECT_EQ(render_scene(*scene_from(scene + "<integrator type=\"" + c.type + "\">" +
                                       c.parameters + "</integrator>"))
                  .data,
              deepest);
    EXPECT_EQ(picture(1), render_scene(*scene_from(scene + integrator_xml("path", 1))).data);
    EXPECT_NE(error_of(integrator_xml(c.type, -2, c.parameters)).find("'max_depth' must be"),
              std::string::npos);
  }
  for (const char* type : {"path", "ptracer", "clustered", "groundtruth"}) {
    const Image black = render_scene(*scene_from(scene + integrator_xml(type, 0)));
    EXPECT_EQ(std::count(black.data.begin(), black.data.end(), 0.f),
              static_cast<ptrdiff_t>(black.data.size()))
        << type;
  }
}

/// In a furnace, paths of at least n edges carry the fraction rho^(n - 2) of all light. The only
/// noise is from roulette, about a thousandth of that.
TEST(LightLeftOut, IsReported) {
  const auto reported = [](const std::string& rho, const std::string& integrator) {
    const std::string text = warning_of(furnace_xml(rho) + integrator);
    if (text.empty()) return text;
    EXPECT_EQ(text.find("kinome: warning: test.xml:1:"), 0u) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    const size_t from = text.find("light after"), to = text.find(" of the image");
    EXPECT_LT(from, to) << text;
    return text.substr(from, to - from);
  };
  const std::string two = "light after two or more bounces is left out: about ";
  const std::string distant = "<string name=\"mode\" value=\"distant\"/>";
  for (const std::string type : {"clustered", "groundtruth"}) {
    const std::string few = type == "groundtruth" ? kJoint.substr(kJoint.find("/>") + 2) : kJoint;
    EXPECT_EQ(reported("0.5", integrator_xml(type, -1, few)), two + "25 %");
    EXPECT_EQ(reported("0.5", "<integrator type=\"" + type + "\">" + few + "</integrator>"),
              two + "25 %");
    EXPECT_EQ(reported("0.9", integrator_xml(type, 4, few)), two + "30 %") << "0.81 / 2.71";
    EXPECT_EQ(reported("0.05", integrator_xml(type, -1, few)), two + "0.2 %") << "0.25 %";
    EXPECT_EQ(reported("0.5", integrator_xml(type, -1, few + distant)),
              "light after one or more bounces is left out: about 50 %");
    // No report: too little light, or light that wasn't requested.
    EXPECT_EQ(reported("0.03", integrator_xml(type, -1, few)), "");
    for (const int depth : {0, 1, 2, 3}) {
      EXPECT_EQ(reported("0.5", integrator_xml(type, depth, few)), "") << depth;
      EXPECT_EQ(reported("0.5", integrator_xml(type, depth, few + distant)), "") << depth;
    }
  }
  EXPECT_EQ(
      reported("0.5", "<integrator type=\"aov\"><string name=\"aovs\" value=\"n:sh_normal\"/>" +
                          integrator_xml("clustered", -1, kJoint) + "</integrator>"),
      two + "25 %");
  // `product` includes all of it, unless local light isn't requested.
  EXPECT_EQ(reported("0.5", integrator_xml("clustered", -1)), "");
  EXPECT_EQ(reported("0.5", integrator_xml("clustered", -1, distant)),
            "light after one or more bounces is left out: about 50 %");
  EXPECT_EQ(reported("0.5", integrator_xml("path", -1)), "");
}

/// Measuring the omitted light changes neither the image nor the ray counts, and doesn't depend on
/// threads. Passes don't report it again.
TEST(LightLeftOut, IsMeasuredBesideTheRender) {
  struct Seen {
    std::vector<float> picture;
    std::string text;
    std::array<uint64_t, kRayKindCount> rays;
    bool operator==(const Seen&) const = default;
  };
  const auto render_with = [](int depth, unsigned threads, uint32_t lanes = 0, uint64_t seed = 0) {
    const auto scene = scene_from(room_xml() + point_xml("0 .8 0", "1") + room_view(8, 4) +
                                  integrator_xml("clustered", depth, kJoint));
    RenderContext context({.threads = threads, .seed = seed, .budget = {.lanes = lanes}});
    testing::internal::CaptureStderr();
    const Image image = render(*scene, *scene->sensors()[0], context);
    return Seen{image.data, testing::internal::GetCapturedStderr(),
                context.job.stats().counters.rays};
  };
  const Seen seen = render_with(-1, 1);
  EXPECT_NE(seen.text.find("is left out"), std::string::npos) << seen.text;
  EXPECT_EQ(render_with(-1, 3), seen);
  Seen plain = render_with(3, 1);
  EXPECT_EQ(plain.text, "");
  plain.text = seen.text;
  EXPECT_EQ(plain, seen);
  const std::string passes = render_with(-1, 2, 4).text;
  EXPECT_EQ(std::count(passes.begin(), passes.end(), '\n'), 1) << passes;
}

/// Light that 4096 paths hardly ever find must not be reported as a number.
TEST(LightLeftOut, NoiseIsNotReported) {
  // A convex shape without surroundings: all light that its faces reflect leaves the scene.
  const std::string scene = shape_xml("cube", "", diffuse_xml(".8 .8 .8")) + constant_xml("1") +
                            sensor_xml("perspective", look_at("3 2 4", "0 0 0", "0 1 0"), 8, 1);
  EXPECT_EQ(warning_of(scene + integrator_xml("clustered", -1, kJoint)), "");
}

}  // namespace
}  // namespace kinome::test::path_test

/// Virtual point lights against path tracing. The mean of `groundtruth` over sets of points is the
/// image of `path` for one bounce, and a single set converges to it as the number of points grows.
/// Images have one pixel, because all pixels of a render share their points and would be dependent.
#include <cmath>

#include "kinome/image_files.h"
#include "kinome/clustered_light.h"
#include "kinome/log.h"
#include "path_scenes.h"

namespace kinome::test::vpl_path_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each z-test

std::string groundtruth_xml(int points, const std::string& mode) {
  return integrator_xml("groundtruth", 3,
                        "<string name=\"mode\" value=\"" + mode +
                            "\"/><integer name=\"light_samples\" value=\"" +
                            std::to_string(points) + "\"/>");
}
std::string vpl_xml(const std::string& placement) {
  return "<emitter type=\"vpl\"><string name=\"placement\" value=\"" + placement + "\"/></emitter>";
}
std::string view(const std::string& from, const std::string& to, int samples) {
  return "<sensor type=\"perspective\"><float name=\"fov\" value=\"30\"/><transform "
         "name=\"to_world\">" +
         look_at(from, to, "0.1 1 0.2") + "</transform><sampler type=\"independent\"><integer " +
         "name=\"sample_count\" value=\"" + std::to_string(samples) +
         "\"/></sampler><film type=\"hdrfilm\"><integer name=\"width\" value=\"1\"/><integer "
         "name=\"height\" value=\"1\"/><rfilter type=\"box\"/></film></sensor>";
}

/// Compares one pixel of `scene_xml` by points and by paths.
void expect_paths_light(const std::string& scene_xml, const std::string& from,
                        const std::string& to, const std::string& name) {
  const auto paths = scene_from(scene_xml + view(from, to, 4096) + integrator_xml("path", 3));
  const auto expected = estimate_pixels(*paths, 24, 500);
  EXPECT_GT(expected[1].mean, 1e-4) << name;
  for (const char* placement : {"surface", "traced"}) {
    const auto points = scene_from(scene_xml + vpl_xml(placement) + view(from, to, 16) +
                                   groundtruth_xml(256, "local"));
    expect_equal(estimate_pixels(*points, 96), expected, kAlpha, name + ", " + placement);
  }
}

const std::string kPhong =
    "<bsdf type=\"phong\"><float name=\"exponent\" value=\"8\"/><rgb name=\"diffuse_reflectance\" "
    "value=\"0.3 0.2 0.1\"/><rgb name=\"specular_reflectance\" value=\"0.2 0.4 0.5\"/></bsdf>";
const std::string kTwoSidedPlastic =
    "<bsdf type=\"twosided\"><bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.4\"/>"
    "</bsdf></bsdf>";
const std::string kSpot =
    "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"35\"/><transform "
    "name=\"to_world\">" +
    look_at("-0.2 0.3 0.2", "1 0 -0.1", "0 1 0") + "</transform></emitter>";

/// The camera sees the floor. Walls of all kinds are lit, far enough from the visible points that
/// 96 sets of points sample the peaks of 1/d².
std::string room_with(const std::string& right_wall, const std::string& lights) {
  const auto wall = [](const std::string& transform, const std::string& content) {
    return shape_xml("rectangle", transform, content);
  };
  return wall("<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\"/>", diffuse_xml("0.7 0.6 0.5")) +
         wall("<rotate x=\"1\" angle=\"90\"/><translate y=\"1\"/>", diffuse_xml("0.4 0.5 0.6")) +
         wall(
             "<rotate y=\"1\" angle=\"-90\"/><scale x=\"1\" y=\"0.7\" z=\"0.7\"/><translate "
             "x=\"1\" y=\"0.3\"/>",
             right_wall) +
         lights;
}

TEST(VplPath, WallsOfEveryKind) {
  const std::pair<const char*, std::string> walls[] = {
      {"diffuse", diffuse_xml("0.8 0.5 0.2")},
      {"phong", kPhong},
      {"two-sided rough plastic", kTwoSidedPlastic},
      {"rough metal", "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.5\"/></bsdf>"},
  };
  for (const auto& [name, bsdf] : walls) {
    expect_paths_light(room_with(bsdf, kSpot), "-0.3 0.5 0.3", "-0.3 -1 0.1", name);
  }
}

TEST(VplPath, LightsOfEveryKind) {
  const std::pair<const char*, std::string> lights[] = {
      {"point", point_xml("0.2 0.4 0.1", "1 2 3")},
      {"sky", constant_xml("0.3 0.4 0.5")},
      {"parallel light",
       "<emitter type=\"directional\"><vector name=\"direction\" value=\"1 0 0\"/></emitter>"},
      {"area light",
       shape_xml("rectangle",
                 "<scale value=\"0.2\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"0.2\" "
                 "y=\"0.5\"/>",
                 area_xml("3 4 5"))},
      {"smooth area light",
       shape_xml("sphere", "<scale value=\"0.15\"/><translate y=\"0.5\"/>", area_xml("3 4 5"))},
      {"all", kSpot + point_xml("0.2 0.4 0.1", "1 2 3") + constant_xml("0.3 0.4 0.5")},
  };
  for (const auto& [name, light] : lights) {
    expect_paths_light(room_with(diffuse_xml("0.8 0.5 0.2"), light), "-0.3 0.5 0.3", "-0.3 -1 0.1",
                       name);
  }
}

/// Curved surfaces: light points use shading normals as paths do.
TEST(VplPath, SmoothNormals) {
  const TemporaryFolder folder;
  // A coarse pyramid without normals gets smooth ones, which differ strongly from those of its
  // faces.
  const std::string file = folder.write("pyramid.obj",
                                        "v 1 -0.5 -0.5\nv 1 -0.5 0.5\nv 1 0.6 0.5\nv 1 0.6 "
                                        "-0.5\nv 0.7 0.05 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
  const std::string mesh = "<shape type=\"obj\"><string name=\"filename\" value=\"" + file +
                           "\"/>" + kTwoSidedPlastic + "</shape>";
  const std::string diffuse_mesh =
      "<shape type=\"obj\"><string name=\"filename\" value=\"" + file +
      "\"/><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf></shape>";
  const std::string floor = shape_xml(
      "rectangle", "<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\"/>", diffuse_xml("0.7"));
  expect_paths_light(floor + mesh + kSpot, "-0.3 0.5 0.3", "-0.3 -1 0.1", "rough plastic");
  expect_paths_light(floor + diffuse_mesh + kSpot, "-0.3 0.5 0.3", "-0.3 -1 0.1", "diffuse");
}

/// Found by kinome-stress: light that arrives from behind a face and passes because of shading
/// normals. Far from the origin, rounding makes surfaces thick.
TEST(VplPath, LightThroughBentNormals) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("wall.obj",
                   "v 1 -0.4 999\nv 1 -0.4 1001\nv 1 1 1001\nv 1 1 999\nvn -0.5 -0.85 0\n"
                   "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n");
  const std::string floor =
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\" z=\"1000\"/>",
                diffuse_xml("0.7"));
  const std::string spot =
      "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"25\"/><transform "
      "name=\"to_world\">" +
      look_at("1.4 -0.8 1000.1", "1 0.4 1000", "1 0 0") + "</transform></emitter>";
  for (const auto& [name, bsdf] :
       {std::pair{"rough plastic", kTwoSidedPlastic}, {"diffuse", diffuse_xml("0.8")}}) {
    const std::string wall = "<shape type=\"obj\"><string name=\"filename\" value=\"" + file +
                             "\"/>" + bsdf + "</shape>";
    expect_paths_light(floor + wall + spot, "-0.3 0.5 1000.3", "-0.3 -1 1000.1", name);
  }
}

TEST(VplPath, NormalMaps) {
  const TemporaryFolder folder;
  // The second is visible only from the side, not straight on, and is flipped for viewers that it
  // faces away from.
  const std::pair<const char*, Vec3> normals[] = {{"tilted", {0.9f, 0.2f, 0.5f}},
                                                  {"below", {-0.8f, 0.3f, -0.2f}}};
  for (const auto& [name, n] : normals) {
    Image map{1, 1, {"R", "G", "B"}, {}};
    const Vec3 colour = glm::normalize(n) * 0.5f + 0.5f;
    map.data = {colour.x, colour.y, colour.z};
    const std::string file = folder.path(name + std::string(".pfm"));
    write_pfm(file, map);
    const std::string wall =
        "<bsdf type=\"normalmap\"><texture type=\"bitmap\" name=\"normalmap\">"
        "<boolean name=\"raw\" value=\"true\"/><string name=\"filename\" "
        "value=\"" +
        file + "\"/></texture>" + diffuse_xml("0.8") + "</bsdf>";
    expect_paths_light(room_with(wall, kSpot), "-0.3 0.5 0.3", "-0.3 -1 0.1", name);
  }
}

/// A single set of points converges as it grows, because its random numbers are independent. At
/// 2^14 points the standard deviation between sets is below 1 %, so that 5 % are five sigma. With
/// dependent numbers the error was a half, for any number of points.
TEST(VplPath, OneSetOfPointsConverges) {
  std::string lamps;
  for (int i = 0; i < 20; ++i) {
    const double a = 0.3 * i;
    lamps +=
        point_xml(std::to_string(0.5 * std::cos(a)) + " 0.5 " + std::to_string(0.5 * std::sin(a)),
                  i % 2 == 0 ? "1 0.2 0.2" : "0.1 0.5 0.5");
  }
  const std::pair<const char*, std::string> lights[] = {
      {"area light", shape_xml("rectangle",
                               "<rotate x=\"1\" angle=\"-90\"/><scale value=\"0.4\"/><translate "
                               "y=\"0.3\" x=\"0.2\"/>",
                               area_xml("3 4 5"))},
      {"sky", constant_xml("1")},
      {"twenty lamps", lamps}};
  for (const auto& [name, light] : lights) {
    const std::string scene_xml = room_with(diffuse_xml("0.8"), light);
    const std::string from = "-0.3 -0.5 0.3", to = "-0.3 -1 0.1";
    const auto paths = scene_from(scene_xml + view(from, to, 16384) + integrator_xml("path", 3));
    const double expected = estimate_pixels(*paths, 2)[1].mean;
    for (const char* placement : {"surface", "traced"}) {
      const auto points = scene_from(scene_xml + vpl_xml(placement) + view(from, to, 64) +
                                     groundtruth_xml(1 << 14, "both"));
      for (const uint64_t seed : {1u, 2u, 3u}) {
        const double shown = estimate_pixels(*points, 1, seed)[1].mean;
        EXPECT_NEAR(shown, expected, 0.05 * expected) << name << ", " << placement;
      }
    }
  }
}

/// Positions are uniform over all surfaces: chi² over cells of two rectangles of different sizes.
/// Stratification makes frequencies more even than chance would, never less.
TEST(VplPath, PositionsAreUniform) {
  const auto scene = scene_from(
      shape_xml("rectangle", "<scale x=\"3\" y=\"1\" z=\"1\"/>", diffuse_xml("0.5")) +
      shape_xml("rectangle", "<scale value=\"0.5\"/><translate z=\"-5\" x=\"10\"/>",
                diffuse_xml("0.5")) +
      "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 -1\"/></emitter>" +
      vpl_xml("surface") + groundtruth_xml(1, "local"));
  RenderContext context({.threads = 2, .seed = 9});
  constexpr uint32_t kPoints = 20000;
  const auto points = light_points_of(*scene->indirect_emitters()[0], *scene, context, kPoints);
  ASSERT_EQ(points->size(), kPoints);
  std::vector<double> observed(8 * 4 + 4), expected(8 * 4 + 4);
  double area = 0;
  for (size_t i = 0; i < points->size(); ++i) {
    const Vec3 p = points->position[i];
    area += points->extent[i];
    if (p.x < 5) {
      ++observed[static_cast<size_t>((p.x + 3) / 6 * 8) * 4 + static_cast<size_t>((p.y + 1) * 2)];
    } else {
      ++observed[32 + (p.x > 10 ? 2 : 0) + (p.y > 0 ? 1 : 0)];
    }
  }
  EXPECT_NEAR(area, 13, 13 * 1e-4);
  for (size_t i = 0; i < 32; ++i) expected[i] = kPoints * (12. / 13) / 32;
  for (size_t i = 32; i < 36; ++i) expected[i] = kPoints * (1. / 13) / 4;
  const Verdict verdict = chi2_test(observed, expected, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

/// Two indirect emitters must not represent the same light.
TEST(VplPath, ABounceCountsOnce) {
  const std::string lamp = "<emitter type=\"point\" id=\"a\"/>";
  const std::string of_lamp = "<emitter type=\"vpl\"><ref id=\"a\"/></emitter>";
  for (const std::string& two : {vpl_xml("surface") + vpl_xml("traced"),
                                 lamp + of_lamp + vpl_xml("traced"), lamp + of_lamp + of_lamp}) {
    std::string message;
    try {
      scene_from(two + floor_xml(diffuse_xml("0.5")));
    } catch (const Error& error) {
      message = error.what();
    }
    EXPECT_NE(message.find("count twice"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace kinome::test::vpl_path_test

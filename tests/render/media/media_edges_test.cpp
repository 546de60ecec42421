/// Values of `volpath` at the edges of its input: extreme coefficients, cameras and boundaries in
/// special positions, open meshes; and its warnings.
#include <gtest/gtest.h>

#include <cmath>

#include "kinome/log_listener.h"
#include "volume_scenes.h"

namespace kinome::test::media_edges_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of 10 z-tests

std::string volpath_xml(int max_depth = -1) {
  return integrator_xml("volpath", max_depth);
}
Rgb grey(double value) {
  return Rgb(static_cast<float>(value));
}
const std::string kSun =
    "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 -1\"/></emitter>";

/// A box of fog over [-9, 9]² that shadow rays along z cross, from `low` to `high`.
std::string layer_xml(float low, float high, const std::string& extinction) {
  const std::string scale = std::to_string((high - low) / 2);
  const std::string middle = std::to_string((high + low) / 2);
  return fog_cube_xml(fog_xml(extinction, "0 0 0"), "<scale x=\"9\" y=\"9\" z=\"" + scale +
                                                        "\"/><translate z=\"" + middle + "\"/>");
}
/// Image of a white floor at z = -3 under a sun, which shines through `media`. Each value is the
/// transmittance divided by pi.
Image sunlit_floor(const std::string& media) {
  return render_scene(*scene_from(
      media + kSun + volpath_xml(2) +
      shape_xml("rectangle", "<scale value=\"9\"/><translate z=\"-3\"/>", diffuse_xml("1 1 1")) +
      sensor_xml("perspective", look_at("0 0 -2", "0 0 -3", "0 1 0"), 4, 4)));
}

/// Chandrasekhar's H function at mu = 1 for isotropic scattering, by iteration of its integral
/// equation: 1 / H(x) = sqrt(1 - a) + a / 2 times the integral of y H(y) / (x + y).
double h_function_at_1(double albedo) {
  constexpr int kNodes = 400;
  const auto node = [](int i) { return (i + 0.5) / kNodes; };
  std::vector<double> h(kNodes, 1);
  const auto value = [&](double x) {
    double sum = 0;
    for (int i = 0; i < kNodes; ++i) sum += node(i) * h[i] / (x + node(i)) / kNodes;
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * sum);
  };
  for (int step = 0; step < 30; ++step) {
    std::vector<double> next;
    for (int i = 0; i < kNodes; ++i) next.push_back(value(node(i)));
    h = next;
  }
  return value(1);
}

TEST(MediaEdges, WithoutExtinctionMediaAreEmpty) {
  const Image image =
      render_scene(*scene_from(fog_cube_xml(fog_xml("0 0 0", "1 1 1")) + constant_xml("0.5 1 2") +
                               volpath_xml() + parallel_view(0.9, 4, 16)));
  const Rgb expected(0.5, 1, 2);
  for (size_t i = 0; i < image.data.size(); ++i) {
    EXPECT_FLOAT_EQ(image.data[i], expected[static_cast<int>(i % 3)]);
  }
}

/// A half-space under a uniform sky has the radiance 1 - sqrt(1 - albedo) H(mu), by reciprocity
/// with Chandrasekhar 1960, chapter V. The surface is at z = 0, because a free path is only 10⁻⁶
/// long: at z = 1, coordinates are rounded by a twentieth of it.
TEST(MediaEdges, OpaqueMediaReflectAtTheirSurface) {
  const double albedo = 0.8;
  const double expected = 1 - std::sqrt(1 - albedo) * h_function_at_1(albedo);
  const auto scene = scene_from(
      fog_cube_xml(fog_xml("1000000 1000000 1000000", "0.8 0.8 0.8"), "<translate z=\"-1\"/>") +
      constant_xml("1 1 1") + volpath_xml() + parallel_view(0.9, 2, 256));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(expected), 4), kAlpha, "opaque");
}

TEST(MediaEdges, AlbedoOneWithoutALimitOfDepthKeepsTheLight) {
  const auto scene = scene_from(fog_cube_xml(fog_xml("4 4 4", "1 1 1")) + constant_xml("1 1 1") +
                                volpath_xml() + parallel_view(0.9, 2, 128));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(1), 4), kAlpha, "white");
}

/// Light takes up to a thousand collisions to leave.
TEST(MediaEdges, DenseFogOfAlbedoOneKeepsTheLight) {
  const auto scene = scene_from(fog_cube_xml(fog_xml("50 50 50", "1 1 1")) + constant_xml("1 1 1") +
                                volpath_xml() + parallel_view(0.9, 2, 32));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(1), 4), kAlpha, "dense");
}

/// Light takes more than 1024 steps to leave, from which roulette makes paths rarer.
TEST(MediaEdges, LongPathsKeepTheirLight) {
  const auto scene = scene_from(fog_cube_xml(fog_xml("500 500 500", "1 1 1")) +
                                constant_xml("1 1 1") + volpath_xml() + parallel_view(0.9, 1, 32));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(1), 1), kAlpha, "long");
}

/// The depth from which roulette ends paths doesn't change the expectation.
TEST(MediaEdges, RouletteKeepsTheMean) {
  const auto estimates = [](int rr_depth, uint64_t seed) {
    const auto scene = scene_from(
        fog_cube_xml(fog_xml("5 5 5", "0.98 0.9 0.5")) + point_xml("0 0 2", "1 1 1") +
        integrator_xml("volpath", -1,
                       "<integer name=\"rr_depth\" value=\"" + std::to_string(rr_depth) + "\"/>") +
        parallel_view(0.9, 2, 64));
    return estimate_pixels(*scene, kRenders, seed);
  };
  expect_equal(estimates(1, 0), estimates(1000000, 1000), kAlpha, "roulette at once, and never");
}

/// Rays that start exactly at a boundary, in the medium that is nested in the sensor.
TEST(MediaEdges, CamerasOnABoundaryAreInTheirMedium) {
  const std::string fog =
      "<medium type=\"homogeneous\" id=\"fog\"><float name=\"sigma_t\" value=\"0.7\"/><float "
      "name=\"albedo\" value=\"0\"/></medium>";
  const std::string cube =
      shape_xml("cube", "", std::string(kBoundary) + "<ref name=\"interior\" id=\"fog\"/>");
  std::string sensor =
      sensor_xml("orthographic",
                 "<scale x=\"0.001\" y=\"0.001\"/>" + look_at("0 0 1", "0 0 0", "0 1 0"), 1, 4096);
  sensor.replace(sensor.rfind("</sensor>"), 9, "<ref id=\"fog\"/></sensor>");
  const auto scene = scene_from(fog + cube + constant_xml("1 1 1") + volpath_xml() + sensor);
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(std::exp(-1.4)), 1), kAlpha,
               "inward");
}

/// Glass of the index of its surroundings doesn't refract, but it scatters: the medium behind it
/// begins at the scattered ray.
TEST(MediaEdges, RefractedRaysEnterTheMedium) {
  const std::string glass =
      "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1\"/><float name=\"ext_ior\" "
      "value=\"1\"/></bsdf>";
  const auto scene = scene_from(shape_xml("cube", "", glass + fog_xml("0.2 0.4 0.8", "0 0 0")) +
                                constant_xml("1 1 1") + volpath_xml() + parallel_view(0.9, 2, 256));
  const Rgb expected(std::exp(-0.4f), std::exp(-0.8f), std::exp(-1.6f));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 4), kAlpha, "glass");
}

TEST(MediaEdges, LayersWithASmallGapAreBothCrossed) {
  const Image image =
      sunlit_floor(layer_xml(0, 1, "0.5 1 0.2") + layer_xml(-1, -0.001f, "0.25 0.5 2"));
  for (size_t i = 0; i < image.data.size(); ++i) {
    const double depth[] = {0.75, 1.5, 2.2};
    EXPECT_NEAR(image.data[i] * kPi, std::exp(-depth[i % 3]), 3e-3);
  }
}

/// A ray hits both or one of two boundaries at the same position. It then continues in the second
/// medium, or in empty space.
TEST(MediaEdges, CoincidentBoundariesAreMetOnceOrTwice) {
  const Image image = sunlit_floor(layer_xml(0, 1, "1 1 1") + layer_xml(-1, 0, "0.5 0.5 0.5"));
  for (const float value : image.data) {
    const double transmittance = value * kPi;
    // Means over 4 samples, each of which is one of the two values.
    EXPECT_GE(transmittance, std::exp(-1.5) - 1e-5);
    EXPECT_LE(transmittance, std::exp(-0.5) + 1e-5);
  }
}

/// Behind an open mesh, the medium continues up to the next boundary or the light.
TEST(MediaEdges, OpenMeshesBeginAMedium) {
  const auto scene = scene_from(
      shape_xml("rectangle", "<scale value=\"4\"/>", kBoundary + fog_xml("0.7 0.3 0.1", "0 0 0")) +
      shape_xml("rectangle", "<scale value=\"4\"/><translate z=\"-2\"/>", area_xml("1 1 1")) +
      volpath_xml() + parallel_view(0.9, 2, 256));
  const Rgb expected(std::exp(-1.4f), std::exp(-0.6f), std::exp(-0.2f));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 4), kAlpha, "open");
}

/// Light that passes through curves stays in the medium on their outside, because it doesn't hit
/// them again.
TEST(MediaEdges, CurvesAreInTheirExterior) {
  const TemporaryFolder folder;
  const std::string curve =
      "<shape type=\"linearcurve\"><string name=\"filename\" value=\"" +
      folder.write("curve.txt", "-9 0 0 2\n9 0 0 2\n") +
      "\"/>" + kBoundary + "<ref name=\"exterior\" id=\"fog\"/></shape>";
  const std::string cube = shape_xml(
      "cube", "<scale value=\"9\"/>",
      std::string(kBoundary) +
          "<medium type=\"homogeneous\" name=\"interior\" id=\"fog\"><float name=\"sigma_t\" "
          "value=\"0.1\"/><float name=\"albedo\" value=\"0\"/></medium>");
  const auto scene = scene_from(cube + curve + constant_xml("1 1 1") + volpath_xml() +
                                sensor_xml("orthographic",
                                           "<scale x=\"0.5\" y=\"0.5\"/>" +
                                               look_at("0 0 20", "0 0 0", "0 1 0"),
                                           2, 256));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(grey(std::exp(-1.8)), 4), kAlpha,
               "curve");
}

/// Warnings of a render by `volpath`.
std::vector<std::string> warnings_of(const std::string& xml) {
  const auto scene = scene_from(xml + volpath_xml());
  std::vector<std::string> warnings;
  const LogListener listener([&](const std::string& warning) { warnings.push_back(warning); });
  RenderContext context({.threads = 1});
  scene->integrator().warn_of_ignored_light(*scene, *scene->sensors().front(), context);
  return warnings;
}
void expect_warning(const std::string& xml, const std::string& text) {
  const auto warnings = warnings_of(xml);
  ASSERT_EQ(warnings.size(), text.empty() ? 0u : 1u) << text;
  for (const auto& warning : warnings) {
    EXPECT_NE(warning.find(text), std::string::npos) << warning;
  }
}

const std::string kFog = "<medium type=\"homogeneous\" id=\"fog\"/>";
std::string sensor_in(const std::string& medium) {
  const std::string ref = medium.empty() ? "" : "<ref id=\"" + medium + "\"/>";
  return "<sensor type=\"perspective\">" + ref + "</sensor>";
}

TEST(MediaWarnings, NameTheMediumInWhichTheSensorStarts) {
  const std::string ball =
      "<shape type=\"sphere\"><bsdf type=\"null\"/><ref name=\"interior\" id=\"fog\"/></shape>";
  const std::string start =
      kFog + "<medium type=\"homogeneous\" id=\"smoke\"/>" + ball + point_xml("0 0 0.5", "1 1 1");
  expect_warning(start + sensor_in(""), "the sensor is in a medium but has none itself");
  expect_warning(start + sensor_in("smoke"), "the sensor's medium isn't that of the shape around");
  expect_warning(start + sensor_in("fog"), "");
  const std::string outside = "<sensor type=\"perspective\"><transform name=\"to_world\">" +
                              look_at("0 0 9", "0 0 0", "0 1 0") + "</transform></sensor>";
  expect_warning(start + outside, "");
}

TEST(MediaWarnings, NameShapesThatAreNotClosed) {
  const auto shape = [](const std::string& type, const std::string& more) {
    return shape_xml(type, "<translate z=\"5\"/>",
                     more + kBoundary + "<ref name=\"interior\" id=\"fog\"/>");
  };
  const std::string start = kFog + sensor_in("") + point_xml("0 0 0.5", "1 1 1");
  const std::string open = " has a medium inside but isn't closed";
  for (const std::string type : {"rectangle", "disk", "cylinder"}) {
    expect_warning(start + shape(type, ""), "shape/" + type + open);
  }
  for (const std::string type : {"sphere", "cube"}) {
    expect_warning(start + shape(type, ""), "");
    expect_warning(start + shape(type, "<boolean name=\"flip_normals\" value=\"true\"/>"),
                   "the geometric normals of shape/" + type + " point into its medium");
  }
  // The sides of a box may be shapes of their own.
  std::string box;
  for (const char* const turn : {"x=\"1\" angle=\"0\"", "x=\"1\" angle=\"90\"",
                                 "x=\"1\" angle=\"180\"", "x=\"1\" angle=\"270\"",
                                 "y=\"1\" angle=\"90\"", "y=\"1\" angle=\"270\""}) {
    box += shape_xml("rectangle",
                     "<translate z=\"1\"/><rotate " + std::string(turn) + "/><translate z=\"5\"/>",
                     std::string(kBoundary) + "<ref name=\"interior\" id=\"fog\"/>");
  }
  expect_warning(start + box, "");
}

TEST(MediaWarnings, NameShapesFarFromTheOriginForTheirFreePath) {
  const auto ball = [](double x, double extinction) {
    return shape_xml("sphere", "<translate x=\"" + std::to_string(x) + "\"/>",
                     "<medium type=\"homogeneous\" name=\"interior\"><float name=\"sigma_t\" value=\"" +
                         std::to_string(extinction) + "\"/></medium>");
  };
  const std::string rest = "<sensor type=\"perspective\"><transform name=\"to_world\">" +
                           look_at("0 0 9", "0 0 0", "0 1 0") + "</transform></sensor>" +
                           point_xml("0 3 0", "1 1 1");
  const std::string message = "the mean free path in the medium of shape/sphere, ";
  expect_warning(ball(0, 9e5) + rest, "");
  expect_warning(ball(0, 2e6) + rest, message + "5e-07, is near the rounding errors");
  expect_warning(ball(2e6, 1) + rest, message + "1, is near");
}

TEST(MediaWarnings, GiveTheEndOfEndlessMedia) {
  const std::string endless = "a medium without a boundary surrounds the scene";
  const std::string ball =
      "<shape type=\"sphere\"><transform name=\"to_world\"><translate "
      "z=\"5\"/></transform></shape>";
  const std::string scene = kFog + ball + sensor_in("fog");
  expect_warning(scene + constant_xml("1 1 1"), endless);
  expect_warning(scene + kSun, endless);
  expect_warning(scene + point_xml("0 1 0", "1 1 1"), "");
  // A boundary ends the medium.
  expect_warning(kFog +
                     "<shape type=\"sphere\"><bsdf type=\"null\"/><ref name=\"interior\" "
                     "id=\"fog\"/></shape>" +
                     sensor_in("fog") + constant_xml("1 1 1"),
                 "");
}

}  // namespace
}  // namespace kinome::test::media_edges_test

/// Sensors that aren't cameras, with all integrators, against closed forms and one another.
#include <gtest/gtest.h>

#include <numbers>

#include "path_scenes.h"

namespace kinome::test::sensors_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 30 z-tests
constexpr int kSamples = 256;
constexpr int kRendersOfEach = 24;

std::string film_xml(int width, int height) {
  return "<film type=\"hdrfilm\"><integer name=\"width\" value=\"" + std::to_string(width) +
         "\"/><integer name=\"height\" value=\"" + std::to_string(height) +
         "\"/><rfilter type=\"box\"/></film><sampler type=\"independent\"><integer "
         "name=\"sample_count\" value=\"" +
         std::to_string(kSamples) + "\"/></sampler>";
}

/// A ball, a lamp over it and a floor, under a sky.
std::string place() {
  return floor_xml(diffuse_xml("0.2 0.5 0.8")) +
         shape_xml("sphere", "<translate value=\"0 1 0\"/>",
                   "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf>") +
         shape_xml("rectangle",
                   "<scale value=\"0.7\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"4\"/>",
                   area_xml("9 5 2")) +
         constant_xml("0.2 0.3 0.4");
}

struct SensorXml {
  const char* name;
  std::string xml;
};
void PrintTo(const SensorXml& sensor, std::ostream* out) {
  *out << sensor.name;
}

std::vector<SensorXml> sensors() {
  const std::string down = "<vector name=\"direction\" value=\"1 -2 .5\"/>";
  const auto part = [](const char* origin) {
    return "<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><transform "
           "name=\"to_world\"><lookat origin=\"" +
           std::string(origin) + "\" target=\"0 .8 0\" up=\"0 1 0\"/></transform></sensor>";
  };
  return {
      {"Distant", "<sensor type=\"distant\">" + down + film_xml(1, 1) + "</sensor>"},
      {"DistantAtAPoint", "<sensor type=\"distant\">" + down +
                              "<point name=\"target\" value=\"1.3 0 .2\"/>" + film_xml(1, 1) +
                              "</sensor>"},
      {"DistantAtAShape",
       "<sensor type=\"distant\">" + down +
           "<shape type=\"rectangle\" name=\"target\"><transform name=\"to_world\"><rotate x=\"1\" "
           "angle=\"-90\"/></transform></shape>" +
           film_xml(2, 1) + "</sensor>"},
      {"RadianceMeter", "<sensor type=\"radiancemeter\"><point name=\"origin\" value=\"4 5 3\"/>"
                        "<vector name=\"direction\" value=\"-3.5 -5 -2\"/>" +
                            film_xml(1, 1) + "</sensor>"},
      {"IrradianceMeter", "<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" "
                          "angle=\"-90\"/><translate x=\"1.5\" y=\".1\"/></transform><sensor "
                          "type=\"irradiancemeter\">" +
                              film_xml(3, 2) + "</sensor></shape>"},
      {"Batch", "<sensor type=\"batch\">" + part("0 3 6") + part("5 2 0") + film_xml(12, 4) +
                    "</sensor>"},
  };
}

class AnySensor : public testing::TestWithParam<SensorXml> {};

TEST_P(AnySensor, IntegratorsAgree) {
  const std::string scene = place() + GetParam().xml;
  const auto of = [&](const std::string& integrator, uint64_t first_seed) {
    return estimate_pixels(*scene_from(scene + integrator), kRendersOfEach, first_seed);
  };
  const auto path = of(integrator_xml("path", 2), 1);
  expect_equal(of(direct_xml(), 50001), path, kAlpha, "direct");
  expect_equal(of(integrator_xml("clustered", 2), 90001), path, kAlpha, "clustered");
  // So few rays use few light points for the bounce, some of which are rare and bright. Single
  // pixels are far from normally distributed, and those of a single ray even in 96 renders.
  if (std::string(GetParam().name) == "RadianceMeter") return;
  const auto tiles_of = [&](const std::string& integrator, uint64_t first_seed) {
    return estimate_tiles(*scene_from(scene + integrator), 4 * kRendersOfEach, 4, first_seed);
  };
  expect_equal(tiles_of(integrator_xml("clustered", 3, "<boolean name=\"trial\" value=\"false\"/>"), 30001),
               tiles_of(integrator_xml("path", 3), 70001), kAlpha, "clustered, a bounce");
}
INSTANTIATE_TEST_SUITE_P(Sensors, AnySensor, testing::ValuesIn(sensors()),
                         [](const auto& one) { return std::string(one.param.name); });

/// Under a constant sky of radiance 1, the irradiance is pi for any shape.
TEST(IrradianceMeter, OfAnEvenSkyIsPi) {
  for (const char* type : {"rectangle", "disk", "sphere", "cylinder", "cube"}) {
    const std::string scene = "<shape type=\"" + std::string(type) +
                              "\"><sensor type=\"irradiancemeter\">" + film_xml(2, 2) +
                              "</sensor></shape>" + constant_xml("1 2 3") +
                              integrator_xml("path", 2);
    const auto rendered = estimate_pixels(*scene_from(scene), 4);
    ASSERT_EQ(rendered.size(), 12u);
    for (size_t i = 0; i < rendered.size(); ++i) {
      EXPECT_NEAR(rendered[i].mean, (1 + static_cast<double>(i % 3)) * std::numbers::pi, 1e-4)
          << type;
    }
  }
}

/// Irradiance of a small lamp of radiance L and area A at distance d straight above: L A / d² near
/// the centre.
TEST(IrradianceMeter, CountsTheCosineOnce) {
  const std::string scene =
      shape_xml("rectangle", "<scale value=\"0.01\"/>",
                "<sensor type=\"irradiancemeter\">" + film_xml(1, 1) + "</sensor>") +
      shape_xml("rectangle", "<scale value=\"0.5\"/><rotate x=\"1\" angle=\"180\"/><translate "
                             "z=\"10\"/>",
                area_xml("100 100 100")) +
      integrator_xml("path", 2);
  const auto rendered = estimate_pixels(*scene_from(scene), 400);
  // cos² / d² over the lamp is within 0.3 % of the value at its centre.
  const double expected = 100. * 1 / (10. * 10);
  EXPECT_NEAR(rendered[0].mean, expected,
              4 * std::sqrt(rendered[0].variance_of_mean) + 0.003 * expected);
}

/// A ball covers the fraction (r / R)² of the sphere around the scene's bounding box.
TEST(Distant, SeesTheCrossSectionOfTheScenesSphere) {
  const std::string scene = "<shape type=\"sphere\">" + area_xml("6 6 6") +
                            "</shape><sensor type=\"distant\"><vector name=\"direction\" "
                            "value=\"1 2 3\"/>" +
                            film_xml(1, 1) + "</sensor>" + integrator_xml("path", 1);
  const auto rendered = estimate_pixels(*scene_from(scene), 64);
  // The sphere around the bounding box of a ball of radius 1 has a radius of sqrt(3).
  expect_equal(rendered, exactly(Rgb(2.f), 1), kAlpha, "a third");
}

TEST(Sensors, OfTheWrongKindOrFilmAreRefused) {
  const auto refuses = [](const std::string& xml, const char* message) {
    try {
      scene_from(xml);
      ADD_FAILURE() << xml;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  refuses("<sensor type=\"irradiancemeter\"/>", "put it into a <shape>");
  refuses("<shape type=\"sphere\"><sensor type=\"perspective\"/></shape>", "move it out of the shape");
  refuses("<sensor type=\"radiancemeter\"/>", "must have one pixel");
  refuses("<sensor type=\"distant\">" + film_xml(2, 2) + "</sensor>", "must have one pixel");
  refuses("<sensor type=\"radiancemeter\"><point name=\"origin\" value=\"1\"/>" + film_xml(1, 1) +
              "</sensor>",
          "requires both origin and direction");
  refuses("<sensor type=\"batch\"><sensor type=\"perspective\"/><sensor type=\"perspective\"/>" +
              film_xml(3, 2) + "</sensor>",
          "must have a width that is a multiple of 2, the number of sensors, got 3");
  refuses("<sensor type=\"batch\"/>", "needs a nested sensor");
}

}  // namespace
}  // namespace kinome::test::sensors_test

/// The BSDF `subsurface`: the medium that it gives to its shapes, and its color.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kinome/bsdf_medium.h"
#include "kinome/log_listener.h"
#include "support/render.h"
#include "volume_scenes.h"

namespace kinome::test::subsurface_test {
namespace {

std::string subsurface_xml(const std::string& color, const std::string& radius,
                           const std::string& more = "") {
  return "<bsdf type=\"subsurface\"><rgb name=\"color\" value=\"" + color +
         "\"/><rgb name=\"radius\" value=\"" + radius + "\"/>" + more + "</bsdf>";
}
std::string error_of(const std::string& shapes) {
  try {
    scene_from("<integrator type=\"volpath\"/>" + shapes);
    return "no error";
  } catch (const Error& error) {
    return error.message();
  }
}

TEST(Subsurface, MediumHasTheRadiusAsFreePath) {
  const auto bsdf = make<Bsdf>(
      subsurface_xml("0 0.5 1", "0.5 2 10",
                     "<float name=\"scale\" value=\"0.1\"/><float name=\"g\" value=\"0.6\"/>"));
  const auto medium = interior_of(*bsdf);
  ASSERT_TRUE(medium);
  EXPECT_TRUE(medium->is_uniform() && medium->is_coloured());
  const MediumCoefficients at = medium->coefficients(Vec3(0.f), Vec3(0, 0, 1));
  EXPECT_LT(glm::length(at.extinction - Rgb(20, 5, 1)), 1e-5f);
  EXPECT_NEAR(at.scattering.x, 0, 1e-3f);
  EXPECT_NEAR(at.scattering.z, 1, 1e-4f);
  const float s = 4.09712f + 2.104315f - std::sqrt(9.59217f + 20.8404f + 4.42815f);
  EXPECT_NEAR(at.scattering.y / 5, (1 - s * s) / (1 - 0.6f * s * s), 1e-5f);
  EXPECT_EQ(medium->phase().lobes()[0].g, 0.6f);
  EXPECT_EQ(medium, interior_of(*bsdf));
}

/// Reflectance of a deep body under uniform light, as irradiance above it, is the color. Its index
/// is nearly that of the surroundings, so that the boundary reflects almost nothing.
TEST(Subsurface, DeepBodiesHaveTheirColor) {
  const std::string meter =
      "<sensor type=\"irradiancemeter\"><sampler type=\"independent\"><integer "
      "name=\"sample_count\" value=\"512\"/></sampler><film type=\"hdrfilm\"><integer "
      "name=\"width\" value=\"1\"/><integer name=\"height\" value=\"1\"/><rfilter "
      "type=\"box\"/></film></sensor>";
  const Rgb color(0.3f, 0.6f, 0.9f);
  const auto scene = scene_from(
      shape_xml("cube", "<translate z=\"-1\"/><scale value=\"500\"/>",
                subsurface_xml("0.3 0.6 0.9", "1 1 1",
                               "<float name=\"int_ior\" value=\"1.0005\"/><float name=\"ext_ior\" "
                               "value=\"1\"/><float name=\"alpha\" value=\"0.01\"/>")) +
      constant_xml("1 1 1") + integrator_xml("volpath", -1) +
      shape_xml("rectangle",
                "<scale value=\"0.1\"/><rotate x=\"1\" angle=\"180\"/><translate z=\"0.1\"/>",
                kBoundary + meter));
  const auto measured = estimate_pixels(*scene, kRenders);
  constexpr double kFit = 0.005, kReflections = 0.002;
  for (int c = 0; c < 3; ++c) {
    const Estimate value = channel(measured, c).front();
    EXPECT_NEAR(value.mean / std::numbers::pi, color[c],
                kFit + kReflections + 4 * std::sqrt(value.variance_of_mean));
  }
}

TEST(Subsurface, IsTheInteriorOfItsShapes) {
  const std::string wax = subsurface_xml("0.5 0.5 0.5", "1 1 1");
  const std::string bumps =
      "<texture type=\"checkerboard\"><float name=\"color0\" value=\"0\"/></texture>";
  const auto scene =
      scene_from("<integrator type=\"volpath\"/>" + shape_xml("sphere", "", wax) +
                 shape_xml("cube", "", "<bsdf type=\"bumpmap\">" + bumps + wax + "</bsdf>") +
                 shape_xml("sphere", "", "<bsdf type=\"roughdielectric\"/>"));
  EXPECT_EQ(scene->media().size(), 2u);
  EXPECT_EQ(scene->shapes()[0]->interior(), scene->media()[0]);
  EXPECT_EQ(scene->shapes()[1]->interior(), scene->media()[1]);
  EXPECT_FALSE(scene->shapes()[2]->separates_media());
}

/// A sensor inside of a body refers to its BSDF.
TEST(Subsurface, IsTheMediumOfASensorInside) {
  const std::string wax = "<bsdf type=\"subsurface\" id=\"wax\"/>";
  const std::string ball =
      "<integrator type=\"volpath\"/>" + shape_xml("sphere", "", "<ref id=\"wax\"/>");
  const auto scene =
      scene_from(wax + ball + "<sensor type=\"perspective\"><ref id=\"wax\"/></sensor>");
  EXPECT_TRUE(scene->sensors()[0]->medium());
  EXPECT_EQ(scene->sensors()[0]->medium(), scene->shapes()[0]->interior());
  EXPECT_EQ(scene->media().size(), 1u);
}

TEST(Subsurface, ErrorsOfSensorsAreFound) {
  const std::string start = "<sensor type=\"perspective\">";
  const std::pair<std::string, const char*> cases[] = {
      {"<bsdf type=\"diffuse\"/>", "'bsdf' must define a medium, as 'subsurface' does, got "},
      {"<bsdf type=\"subsurface\"/><medium type=\"homogeneous\"/>",
       "'bsdf' can't be combined with a medium"},
  };
  for (const auto& [contents, message] : cases) {
    const std::string error = error_of(start + contents + "</sensor>");
    EXPECT_NE(error.find(message), std::string::npos) << error;
  }
}

TEST(Subsurface, ErrorsAreFound) {
  const std::string wax = subsurface_xml("0.5 0.5 0.5", "1 1 1");
  const std::string blend = "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/>" +
                            wax + subsurface_xml("0.9 0.5 0.5", "1 1 1") + "</bsdf>";
  const std::pair<std::string, const char*> cases[] = {
      {wax + fog_xml("1 1 1", "1 1 1"), "its BSDF defines another one"},
      {blend, "have different interior media"},
      {subsurface_xml("0.5 0.5 1.1", "1 1 1"), "'color' is outside [0,1]"},
      {subsurface_xml("0.5 0.5 0.5", "1 0 1"), "'radius' must be at least 1e-9"},
      {subsurface_xml("0.5 0.5 0.5", "1 -1 1"), "'radius' must not be negative"},
      {subsurface_xml("0.5 0.5 0.5", "1 1 1", "<float name=\"g\" value=\"1\"/>"),
       "'g' must be greater than -1 and less than 1"},
      {subsurface_xml("0.5 0.5 0.5", "1 1 1", "<float name=\"scale\" value=\"0\"/>"),
       "'scale' must be positive"},
      {"<bsdf type=\"subsurface\"><texture type=\"checkerboard\" name=\"color\"/></bsdf>",
       "'color' must be uniform"},
  };
  for (const auto& [contents, message] : cases) {
    const std::string error = error_of(shape_xml("sphere", "", contents));
    EXPECT_NE(error.find(message), std::string::npos) << error;
  }
}

/// Integrators without media show glass, with the warning that every medium causes.
TEST(Subsurface, IsGlassWithoutMedia) {
  std::vector<std::string> warnings;
  const LogListener listener([&](const std::string& warning) { warnings.push_back(warning); });
  const auto render = [](const std::string& bsdf) {
    return render_scene(*scene_from(shape_xml("sphere", "", bsdf) + constant_xml("1 0.5 0.2") +
                                    integrator_xml("path", -1) + parallel_view(1.2, 8, 4)));
  };
  const Image wax = render(subsurface_xml("0.5 0.5 0.5", "1 1 1"));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("media are ignored"), std::string::npos) << warnings[0];
  EXPECT_EQ(wax.data, render("<bsdf type=\"roughdielectric\"/>").data);
}

}  // namespace
}  // namespace kinome::test::subsurface_test

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinome/image_files.h"
#include "kinome/instruction_set.h"
#include "sdk.h"
#include "sdk/examples.h"
#include "support/png.h"

/// Tests the SDK's examples of samplers, sensors, shapes, filters and films.
namespace kinome::test::category_examples_test {
namespace {

using namespace examples;

/// Returns a scene of 16 x 16 pixels with the named sensor and its contents.
std::string scene_of(const std::string& integrator, const std::string& sensor,
                     const std::string& inside, const std::string& rfilter = "box",
                     int samples = 64) {
  return "<scene version='3.0.0'><integrator type='" + integrator + "'/><sensor type=" + sensor +
         "<sampler type='independent'><integer name='sample_count' value='" +
         std::to_string(samples) +
         "'/></sampler><film type='hdrfilm'><integer name='width' value='16'/>"
         "<integer name='height' value='16'/><string name='component_format' value='float32'/>"
         "<rfilter type='" +
         rfilter + "'/></film></sensor>" + inside + "</scene>";
}

const char* const kSky = R"(<emitter type="sky_gradient"><rgb name="zenith" value="2"/>
    <rgb name="horizon" value="1"/></emitter>)";

/// Stratified numbers leave less noise than independent ones, with the same mean.
TEST_F(Sdk, SamplerSpreadsItsNumbers) {
  const std::string scene = floor_scene("direct", kSky);
  const double expected = .5 * (1 + 2. / 3);
  double errors[2] = {0, 0};
  const Image images[] = {
      render_text(scene),
      render_text(replaced(scene, "<sampler type=\"independent\">", "<sampler type=\"golden\">"))};
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(images[i].width, 16);
    // The tolerance is that of SkyGradientLightsAFloorAsDerived.
    EXPECT_NEAR(mean_of(images[i]).x, expected, expected * 5 / 128);
    for (int p = 0; p < 16 * 16; ++p) {
      errors[i] += std::pow(images[i].at(p % 16, p / 16, 0) - expected, 2);
    }
  }
  EXPECT_LT(errors[1], errors[0] / 4);
}

/// The sky by the camera's formula: each pixel's value is between those of its positions.
TEST_F(Sdk, SensorSeesAllOfTheSky) {
  for (const bool looks_up : {true, false}) {
    const std::string to_world =
        looks_up ? "<transform name='to_world'><lookat origin='0 0 0' target='0 1 0' up='0 0 1'/>"
                   "</transform>"
                 : "";
    const Image image = render_text(scene_of("direct", "'fisheye'>" + to_world, kSky));
    ASSERT_EQ(image.width, 16);
    for (int p = 0; p < 16 * 16; ++p) {
      double low = 2, high = 1;
      for (int k = 0; k < 9 * 9; ++k) {
        const double x = p % 16 - 8 + k % 9 / 8., y = p / 16 - 8 + k / 9 / 8.;
        const double r = std::hypot(x, y), angle = r * M_PI / 16;
        const double up = looks_up ? std::cos(angle) : r > 0 ? -std::sin(angle) * y / r : 0;
        low = std::min(low, 1 + std::max(up, 0.));
        high = std::max(high, 1 + std::max(up, 0.));
      }
      // Between the 81 positions, the sky may slightly exceed their range.
      EXPECT_GE(image.at(p % 16, p / 16, 0), low - 1e-3) << p;
      EXPECT_LE(image.at(p % 16, p / 16, 0), high + 1e-3) << p;
    }
  }
}

/// The ring seen directly, and lighting a ceiling that is visible through its hole. Closed form:
/// under a ring of radiance 1 with radii a < b, at distance h from its centre, irradiance is
/// pi (b² / (b² + h²) - a² / (a² + h²)).
TEST_F(Sdk, ShapeIsSeenAndShines) {
  const std::string ring = R"(<shape type="ring"><float name="radius" value=".8"/>
      <float name="inner" value=".4"/>)";
  const std::string above =
      "<transform name='to_world'><lookat origin='0 0 3' target='0 0 0' up='0 1 0'/></transform>";
  const Rgb seen =
      mean_of(render_text(scene_of("normals", "'orthographic'>" + above, ring + "</shape>")));
  // Fraction of 16384 rays in an image of area 4, with a standard deviation of .0038.
  const double share = M_PI * (.64 - .16) / 4;
  EXPECT_NEAR(seen.z, share, 5 * .0038);
  EXPECT_NEAR(seen.x, share / 2, 5 * .0019);

  const std::string below =
      "<float name='fov' value='2'/><transform name='to_world'>"
      "<lookat origin='0 0 -3' target='0 0 1' up='0 1 0'/></transform>";
  const std::string ceiling =
      R"(<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/>
      <scale value="4"/><translate z="1"/></transform>
      <bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf></shape>)";
  const Rgb lit = mean_of(render_text(scene_of(
      "direct", "'perspective'>" + below,
      ring + "<emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>" + ceiling)));
  const double expected = .5 * (.64 / 1.64 - .16 / 1.16);
  // Samples vary by less than their mean. The mean is over points up to .1 from the axis, which
  // differ by less than 1 %.
  EXPECT_NEAR(lit.x, expected, expected * (5. / 128 + .01));

  // The ring also reflects light of other plugins here: with 'joint', by light points on it.
  const std::string under_sky = ring + "</shape>" + ceiling + "<emitter type='sky_gradient'/>";
  const Rgb direct = mean_of(render_text(scene_of("direct", "'perspective'>" + below, under_sky)));
  const Rgb bounced =
      mean_of(render_text(scene_of("clustered", "'perspective'>" + below, under_sky)));
  // The ring sees only the fraction 1/17 of the sky that is beside the ceiling, and is .25 of what
  // the ceiling sees. It therefore adds less than .25 x .5 / 17. Both values vary as above, with a
  // standard deviation below their mean.
  EXPECT_NEAR(bounced.x, direct.x, direct.x * (.25 * .5 / 17 + 5 * std::sqrt(2.) / 128));
}

/// With each instruction set, a constant image stays constant, and an edge becomes the window's
/// integral.
TEST_F(Sdk, FilterBlursAnEdge) {
  const std::string above =
      "<transform name='to_world'><lookat origin='0 0 3' target='0 0 0' up='0 1 0'/></transform>";
  const std::string half =
      "<shape type='rectangle'><transform name='to_world'><scale value='2'/>"
      "<translate x='2'/></transform></shape>";
  const fs::path folder = fs::path(plugins()) / "rfilter";
  for (const std::string& set : sets_built(folder, {"hann.so"})) {
    if (!is_usable(set)) continue;
    const Image flat = render_text(
        replaced(floor_scene("normals", ""), "<rfilter type=\"box\"/>", "<rfilter type=\"hann\"/>"),
        {"--isa", set});
    const Image edge = render_text(
        scene_of("normals", "'orthographic'>" + above, half, "hann", 1024), {"--isa", set});
    ASSERT_EQ(flat.width, 16);
    ASSERT_EQ(edge.width, 16);
    for (int p = 0; p < 16 * 16; ++p) EXPECT_NEAR(flat.at(p % 16, p / 16, 1), 1, 1e-6) << set;
    double columns[16] = {};
    for (int p = 0; p < 16 * 16; ++p) columns[p % 16] += edge.at(p % 16, p / 16, 2) / 16;
    if (columns[0] > columns[15]) std::reverse(columns, columns + 16);
    // Half a pixel from the edge. There are 16 x 1024 samples in each of three columns, and their
    // squared weights have a mean of 3/8: a standard deviation below .5 / sqrt(3 x 16384 / 1.5) =
    // .0028.
    const double expected = .5 + .5 / 3 + std::sin(M_PI / 3) / (2 * M_PI);
    EXPECT_NEAR(columns[8], expected, 5 * .0028) << set;
    EXPECT_NEAR(columns[7], 1 - expected, 5 * .0028) << set;
    EXPECT_EQ(columns[5], 0) << set;
    EXPECT_NEAR(columns[10], 1, 1e-6) << set;
  }
}

/// An image of a floor that `normals` shows as (.5, 1, .5), half as bright.
TEST_F(Sdk, FilmWritesItsFormat) {
  const std::string scene = folder_->write(
      "film.xml", replaced(replaced(floor_scene("normals", ""), "<film type=\"hdrfilm\">",
                                    "<film type='png'><float name='exposure' value='-1'/>"),
                           R"(<string name="component_format" value="float32"/>)", ""));
  // The film adds its extension.
  expect_success(run_process(
      {program(), "-q", scene, "-o", folder_->path("picture"), "--plugin-path", plugins()}));
  const Png png = read_png(folder_->path("picture.png"));
  ASSERT_EQ(png.width, 16u);
  ASSERT_EQ(png.height, 16u);
  for (size_t p = 0; p < 16 * 16; ++p) {
    EXPECT_EQ(png.rgba[4 * p], 137);
    EXPECT_EQ(png.rgba[4 * p + 1], 188);
    EXPECT_EQ(png.rgba[4 * p + 2], 137);
  }
}

}  // namespace
}  // namespace kinome::test::category_examples_test

/// Image files as in public scenes: a scene shows the colour that the file's author intended.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kinome/image_files.h"
#include "kinome/film.h"
#include "kinome/sensor.h"
#include "support/render.h"

namespace kinome::test::image_files_test {
namespace {

/// A 4x4 film with `pixel_format` in front of a rectangle that fills the image.
std::string card_xml(const std::string& content, const std::string& pixel_format = "rgb") {
  return "<integrator type='direct'><integer name='emitter_samples' value='0'/><integer "
         "name='bsdf_samples' value='1'/></integrator><sensor type='orthographic'><transform "
         "name='to_world'>"
         "<lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform>"
         "<sampler type='independent'><integer name='sample_count' value='1'/></sampler>"
         "<film type='hdrfilm'><rfilter type='box'/><string name='pixel_format' value='" +
         pixel_format +
         "'/><string name='component_format' value='float32'/>"
         "<integer name='width' value='4'/><integer name='height' value='4'/></film></sensor>"
         "<shape type='rectangle'>" +
         content + "</shape>";
}

std::string image_xml(const std::string& path, const std::string& name) {
  return "<texture type='bitmap' name='" + name + "'><string name='filename' value='" + path +
         "'/></texture>";
}

Rgb first_pixel(const Scene& scene) {
  const Image image = render_scene(scene);
  return {image.at(0, 0, 0), image.at(0, 0, 1), image.at(0, 0, 2)};
}

void expect_color(const Rgb& color, const Rgb& expected, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], tolerance) << c;
}

/// A film of X, Y and Z writes a file that a texture and an environment read as the same colour.
TEST(ImageFiles, AFilmOfXyzIsReadAsItsColours) {
  const TemporaryFolder folder;
  const auto written = scene_from(card_xml(
      "<emitter type='area'><rgb name='radiance' value='0.8 0.2 0.05'/></emitter>", "xyz"));
  const Image image = render_scene(*written);
  const std::string path = folder.path("card.exr");
  written->sensors().at(0)->film().write(folder.path("card"), image, {});
  const Rgb color(0.8f, 0.2f, 0.05f);
  expect_color(first_pixel(*scene_from(
                   card_xml("<emitter type='area'>" + image_xml(path, "radiance") + "</emitter>"))),
               color, 1e-5f);
  const auto sky = make<Emitter>("<emitter type='envmap'><string name='filename' value='" + path +
                                 "'/></emitter>");
  expect_color(sky->eval_environment(Vec3(0, 0, 1)), color, 1e-5f);
}

/// Reflectances of 1.002 and 20 render as white paper in a white furnace, NaN as black.
TEST(ImageFiles, ReflectancesThatAreNoneRender) {
  const TemporaryFolder folder;
  const std::string path = folder.path("paper.exr");
  write_exr(path, Image{1, 1, {"R", "G", "B"}, {1.002f, 20, std::nanf("")}}, ExrSampleType::kFloat,
            {});
  testing::internal::CaptureStderr();
  const auto scene =
      scene_from("<emitter type='constant'/>" +
                 card_xml("<bsdf type='diffuse'>" + image_xml(path, "reflectance") + "</bsdf>"));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2) << log;
  EXPECT_NE(log.find("1 texel with NaN, which becomes 0"), std::string::npos) << log;
  EXPECT_NE(log.find("they are clamped to that range"), std::string::npos) << log;
  expect_color(first_pixel(*scene), Rgb(1, 1, 0), 1e-5f);
}

/// A warning about an image's values appears once, even if several plugins use it.
TEST(ImageFiles, NegativeTexelsAreReportedOnce) {
  const TemporaryFolder folder;
  const std::string path = folder.path("sky.exr");
  write_exr(path, Image{2, 1, {"Y"}, {1, -0.25f}}, ExrSampleType::kFloat, {});
  testing::internal::CaptureStderr();
  scene_from("<emitter type='envmap'><string name='filename' value='" + path + "'/></emitter>" +
             card_xml("<bsdf type='diffuse'>" + image_xml(path, "reflectance") + "</bsdf>") +
             "<shape type='rectangle'><bsdf type='diffuse'>" + image_xml(path, "reflectance") +
             "</bsdf></shape>");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "kinome: warning: " + path +
                ": 1 texel is negative, with 20 % of the image's energy, and is kept\n");
}

}  // namespace
}  // namespace kinome::test::image_files_test

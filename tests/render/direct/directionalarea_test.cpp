/// `directionalarea` by light tracing: a parallel beam, and a ball whose light spreads as from a
/// point. All other integrators show black, as in Mitsuba.
#include <gtest/gtest.h>

#include <cmath>

#include "direct_scenes.h"

namespace kinome::test::directionalarea_test {
namespace {

/// A floor in z = 0 of reflectance 0.5 under light of 1, 2, 3, seen from above: its inner 3 x 3.
std::string scene_xml(const std::string& shape, const std::string& integrator,
                      const std::string& radiance = "<rgb name=\"radiance\" value=\"1 2 3\"/>") {
  return "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/></transform>" +
         diffuse_xml("0.5") + "</shape>" + shape +
         "<emitter type=\"directionalarea\">" + radiance + "</emitter></shape>" +
         sensor_xml("orthographic", "<scale value=\"1.5\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"), 3,
                    256) +
         integrator;
}

const std::string kPtracer =
    "<integrator type=\"ptracer\"><integer name=\"max_depth\" value=\"2\"/></integrator>";

/// A rectangle of side 2 that faces down from z = 6, above the camera.
const std::string kLamp =
    "<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"180\"/><translate "
    "z=\"6\"/></transform>";

std::vector<Estimate> pixel(const std::vector<Estimate>& all, int i) {
  return {all.begin() + 3 * i, all.begin() + 3 * i + 3};
}

/// The floor right below the lamp receives the lamp's flux per area; the rest receives none.
TEST(DirectionalArea, IsAParallelBeam) {
  const auto estimate = estimate_pixels(*scene_from(scene_xml(kLamp, kPtracer)), kRenders);
  const float e = 0.5f * kInvPi;
  expect_equal(pixel(estimate, 4), exactly(e * Rgb(1, 2, 3), 1), 1e-5, "below");
  // Pixels are 1 wide, starting at -1.5: half of the neighbour is lit, and a quarter of the
  // diagonal one.
  expect_equal(pixel(estimate, 5), exactly(0.5f * e * Rgb(1, 2, 3), 1), 1e-5, "beside");
  expect_equal(pixel(estimate, 0), exactly(0.25f * e * Rgb(1, 2, 3), 1), 1e-5, "across");
}

/// A texture shapes the beam.
TEST(DirectionalArea, FollowsItsTexture) {
  const std::string texture =
      "<texture type=\"checkerboard\" name=\"radiance\"><rgb name=\"color0\" value=\"2 2 2\"/><rgb "
      "name=\"color1\" value=\"0 0 0\"/></texture>";
  const auto estimate = estimate_pixels(*scene_from(scene_xml(kLamp, kPtracer, texture)), kRenders);
  expect_equal(pixel(estimate, 4), exactly(Rgb(0.5f * kInvPi), 1), 1e-5, "half of it is lit");
}

/// Radius 0.5, height 6: at a distance d from its centre, the irradiance is radiance x (r / d)².
TEST(DirectionalArea, OfABallSpreadsAsFromAPoint) {
  const std::string ball =
      "<shape type=\"sphere\"><point name=\"center\" value=\"0 0 6\"/><float name=\"radius\" "
      "value=\"0.5\"/>";
  const auto estimate = estimate_pixels(*scene_from(scene_xml(ball, kPtracer)), kRenders);
  double sum = 0;  // of cosine³ over the central pixel: E = L r² cos³ / h²
  for (int i = 0; i < 10000; ++i) {
    const double x = (i % 100 + 0.5) / 100 - 0.5, y = (i / 100 + 0.5) / 100 - 0.5;
    sum += std::pow(36 / (36 + x * x + y * y), 1.5) / 10000;
  }
  const auto e = static_cast<float>(0.5 * kInvPi * sum * 0.25 / 36);
  expect_equal(pixel(estimate, 4), exactly(e * Rgb(1, 2, 3), 1), 1e-5, "ball");
}

TEST(DirectionalArea, IsBlackForCameraPaths) {
  for (const char* type : {"path", "direct", "clustered"}) {
    const Image image = render_scene(
        *scene_from(scene_xml(kLamp, "<integrator type=\"" + std::string(type) + "\"/>")));
    for (const float value : image.data) EXPECT_EQ(value, 0) << type;
  }
}

}  // namespace
}  // namespace kinome::test::directionalarea_test

/// `groundtruth` and `clustered` against radiances in closed form and against `direct`. Also tests
/// their common features: mirrors, emitters without light points, emitters hidden from the camera.
#include <gtest/gtest.h>

#include <cmath>

#include "direct_scenes.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/sphere_partition.h"

namespace kinome::test::point_lights_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 60 z-tests

const std::string kGroundTruth =
    "<integrator type=\"groundtruth\"><integer name=\"light_samples\" "
    "value=\"4096\"/><integer name=\"max_depth\" value=\"2\"/></integrator>";

std::string clustered_xml(const std::string& importance, const std::string& more = "") {
  return "<integrator type=\"clustered\"><integer name=\"max_depth\" value=\"2\"/><integer "
         "name=\"light_samples\" value=\"4096\"/>"
         "<integer name=\"cut_size\" value=\"128\"/><integer name=\"emitter_samples\" "
         "value=\"16\"/><string name=\"importance\" value=\"" +
         importance + "\"/>" + more + "</integrator>";
}
const char* const kImportances[] = {"joint", "luminance", "brdf"};

std::string floor_view(const char* sampler, int samples) {
  return sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 3, samples, sampler);
}

/// A floor under a constant sky has the radiance reflectance x radiance, except for the error with
/// which 4096 points integrate the cosine. The sum of their cosines gives this error.
TEST(PointLights, ConstantEnvironmentOnADiffusePlane) {
  const SpherePartition sphere(4096);
  double cosine = 0;
  for (uint32_t i = 0; i < sphere.size(); ++i) cosine += std::max(0.f, sphere.centre(i).y);
  const double share = cosine * sphere.cell_solid_angle() / kPi;
  EXPECT_NEAR(share, 1, 1e-3);  // the ring across the horizon is 1/50 of the sphere's height
  const Rgb expected = Rgb(0.2, 1, 2.4) * static_cast<float>(share);

  const std::string scene_xml = floor_xml(diffuse_xml("0.2 0.5 0.8")) + constant_xml("1 2 3");
  const auto truth = scene_from(scene_xml + kGroundTruth + floor_view("independent", 1));
  const auto shown = estimate_pixels(*truth, 2);
  for (size_t i = 0; i < shown.size(); ++i) {
    const double exact = expected[static_cast<int>(i % 3)];
    // Half of 4096 floats are summed one after another: the error is at most half an ulp for each.
    EXPECT_NEAR(shown[i].mean, exact, 2048 * 0x1p-24 * exact);
  }
  for (const char* sampler : kSamplers) {
    for (const char* importance : kImportances) {
      const auto scene = scene_from(scene_xml + clustered_xml(importance) + floor_view(sampler, 4));
      expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 9), kAlpha,
                   std::string(sampler) + ", " + importance);
    }
  }
}

/// A single bright texel with the irradiance derived in closed_form_test.cpp. Each point is at the
/// centre of a cell 0.055 wide. Over the two texels' width (0.2) first-order errors cancel, and
/// 0.055² / 24 is 1.3e-4. The remaining error, under 1 %, is from cells across the tent's edge.
TEST(PointLights, SingleTexelAsASun) {
  constexpr int kWidth = 64, kHeight = 33, kRow = 7;
  constexpr float kRadiance = 5000;
  const double dphi = 2 * M_PI / kWidth, dtheta = M_PI / (kHeight - 1), theta = kRow * dtheta;
  const double irradiance = kRadiance * dphi * 0.5 * std::sin(2 * theta) * dtheta *
                            std::pow(std::sin(dtheta) / dtheta, 2);
  const double expected = 0.5 * irradiance / M_PI;
  const TemporaryFolder folder;
  const std::string scene_xml =
      floor_xml(diffuse_xml("0.5")) + envmap_xml(folder, kWidth, kHeight, [](int x, int y) {
        return x == 0 && y == kRow ? Rgb(kRadiance) : Rgb(0.f);
      });
  const auto truth = scene_from(scene_xml + kGroundTruth + floor_view("independent", 1));
  const double shown = estimate_pixels(*truth, 2)[0].mean;
  EXPECT_NEAR(shown, expected, 0.01 * expected);
  for (const char* importance : kImportances) {
    const auto scene =
        scene_from(scene_xml + clustered_xml(importance) + floor_view("independent", 16));
    expect_equal(estimate_pixels(*scene, kRenders), exactly(Rgb(shown), 9), kAlpha, importance);
  }
}

/// A sphere in a white furnace must look as with `direct`, including mirrors. closed_form_test.cpp
/// compares that with each material's albedo.
TEST(PointLights, FurnaceAsDirectShowsIt) {
  const char* const materials[] = {
      "<bsdf type=\"diffuse\"/>",
      "<bsdf type=\"phong\"><float name=\"exponent\" value=\"20\"/></bsdf>",
      "<bsdf type=\"ward\"><float name=\"alpha\" value=\"0.3\"/></bsdf>",
      "<bsdf type=\"conductor\"><string name=\"material\" value=\"Cu\"/></bsdf>",
      R"(<bsdf type="roughconductor"><string name="material" value="Au"/>
        <float name="alpha" value="0.3"/></bsdf>)",
      "<bsdf type=\"plastic\"/>",
      "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/></bsdf>",
      "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>"};
  for (const char* material : materials) {
    const std::string scene_xml =
        "<shape type=\"sphere\">" + std::string(material) + "</shape>" + constant_xml("1") +
        sensor_xml("orthographic", "<scale value=\"1.25\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"),
                   4, 4);
    const auto direct = scene_from(scene_xml + direct_xml());
    const auto clustered = scene_from(scene_xml + clustered_xml("joint"));
    expect_equal(estimate_pixels(*clustered, kRenders, 1000), estimate_pixels(*direct, kRenders),
                 kAlpha, material);
  }
}

TEST(PointLights, HiddenEmittersAreBlackToTheCameraAlone) {
  const std::string scene_xml =
      "<shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>" + constant_xml("1") +
      sensor_xml("orthographic", "<scale value=\"2\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"), 5, 4,
                 "independent", "rgba");
  const auto visible = scene_from(scene_xml + clustered_xml("joint"));
  const auto hidden = scene_from(
      scene_xml + clustered_xml("joint", "<boolean name=\"hide_emitters\" value=\"true\"/>"));
  const Image a = render_scene(*visible), b = render_scene(*hidden);
  EXPECT_EQ(a.at(0, 0, 0), 1);
  EXPECT_EQ(b.at(0, 0, 0), 0);
  EXPECT_EQ(a.at(0, 0, 3), 1);
  EXPECT_EQ(b.at(0, 0, 3), 0);
  EXPECT_EQ(a.at(2, 2, 3), 1);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(a.at(2, 2, c), b.at(2, 2, c));
}

/// An emitter between the camera and the ball: the camera looks through it, and it lights the ball.
TEST(PointLights, HiddenEmittersDontHideSurfacesBehind) {
  const std::string scene_xml =
      "<shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape><shape type=\"rectangle\"><transform "
      "name=\"to_world\"><rotate x=\"1\" angle=\"180\"/><translate z=\"2\"/></transform><emitter "
      "type=\"area\"/></shape>" +
      sensor_xml("orthographic", "<scale value=\"0.5\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"), 3,
                 16, "independent", "rgba");
  for (const char* integrator : {"clustered", "groundtruth"}) {
    const std::string begin = std::string("<integrator type=\"") + integrator +
                              "\"><integer name=\"max_depth\" value=\"2\"/>";
    const std::string hide = "<boolean name=\"hide_emitters\" value=\"true\"/></integrator>";
    const Image seen = render_scene(*scene_from(scene_xml + begin + "</integrator>"));
    const Image hidden = render_scene(*scene_from(scene_xml + begin + hide));
    EXPECT_EQ(seen.at(1, 1, 0), 0) << "the lamp's back";
    EXPECT_GT(hidden.at(1, 1, 0), 0.05f);
    EXPECT_EQ(hidden.at(1, 1, 3), 1);
  }
}

/// Light straight down, without light points.
class Beam final : public Emitter {
 public:
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override {
    DirectSample sample;
    sample.d = Vec3(0, 1, 0);
    sample.pdf = 1;
    sample.radiance = Rgb(2, 4, 6);
    sample.is_delta = true;
    return sample;
  }
};

TEST(PointLights, EmittersWithoutPointsAreSampledOneByOne) {
  Scene::Contents contents;
  contents.shapes.push_back(make<Shape>(floor_xml(diffuse_xml("0.5"))));
  contents.emitters.push_back(std::make_shared<Beam>());
  contents.sensors.push_back(make<Sensor>(floor_view("independent", 1)));
  contents.integrator = make<Integrator>(clustered_xml("joint"));
  const Scene scene(std::move(contents), 1);
  const Image image = render_scene(scene);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(image.at(1, 1, c), 0.5f * kInvPi * static_cast<float>(2 + 2 * c), 1e-6f);
  }
}

}  // namespace
}  // namespace kinome::test::point_lights_test

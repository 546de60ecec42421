// Tests that `clustered` with virtual point lights, in every mode, estimates the result of
// `groundtruth` from the same points. Renders of one seed have the same light points and pixel
// positions. Their difference has mean 0, and only the choice of points contributes variance.
#include <gtest/gtest.h>

#include "clustered_cases.h"

namespace kinome::test::local_clustered_test {
namespace {

/// A room that a spot lights by way of a wall, with a curved and a flat object.
std::unique_ptr<Scene> room(const std::string& integrator, const std::string& bsdf,
                            const std::string& more, const std::string& sampler) {
  const auto wall = [](const char* placement, const char* color) {
    return std::string("<shape type=\"rectangle\"><transform name=\"to_world\">") + placement +
           "</transform><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"" + color +
           "\"/></bsdf></shape>";
  };
  return scene_from(
      integrator + more + R"(
    <sensor type="perspective"><float name="fov" value="60"/>
      <transform name="to_world"><lookat origin="0,1.2,2.9" target="0,.7,0" up="0,1,0"/></transform>
      )" +
      sampler + R"(
      <film type="hdrfilm"><integer name="width" value="10"/><integer name="height" value="8"/>
        <rfilter type="box"/></film></sensor>
    <shape type="sphere"><point name="center" x="-.3" y=".5" z="0"/><float name="radius" value=".4"/>)" +
      bsdf + R"(</shape>
    <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/>
      <scale value="1.5"/></transform>)" +
      bsdf + "</shape>" + wall("<scale value='1.5'/><translate y='1' z='-1.5'/>", ".7 .7 .7") +
      wall("<scale value='1.5'/><rotate y='1' angle='-90'/><translate x='1.5' y='1'/>",
           ".3 .7 .3") +
      wall("<scale value='1.5'/><rotate y='1' angle='90'/><translate x='-1.5' y='1'/>",
           ".7 .2 .2"));
}

constexpr const char* kSpot = R"(<emitter type="spot"><transform name="to_world">
    <lookat origin="-1,1.6,.8" target="1.5,.9,-.6" up="0,1,0"/></transform>
  <rgb name="intensity" value="30 25 20"/><float name="cutoff_angle" value="25"/></emitter>)";
constexpr const char* kPoint =
    R"(<emitter type="point"><point name="position" x=".9" y="1.6" z=".5"/>
  <rgb name="intensity" value="3 4 5"/></emitter>)";
constexpr const char* kSky =
    R"(<emitter type="constant"><rgb name="radiance" value=".3 .4 .5"/></emitter>)";

struct Case {
  const char* name;
  std::string bsdf;
  std::string parameters;
  std::string more = kSpot;
  std::string sampler = sampler_xml("independent");
};

class LocalAgainstGroundTruth : public testing::TestWithParam<Case> {};

TEST_P(LocalAgainstGroundTruth, HasItsExpectation) {
  const Case& c = GetParam();
  const std::string points =
      R"(<integer name="light_samples" value="400"/><integer name="max_depth" value="3"/>)";
  const auto truth = room("<integrator type=\"groundtruth\">" + points + "</integrator>", c.bsdf,
                          c.more, c.sampler);
  const auto clustered =
      room("<integrator type=\"clustered\">" + points + c.parameters + "</integrator>", c.bsdf,
           c.more, c.sampler);
  double brightness = 0;
  for (const Estimate& pixel : estimate_pixels(*truth, 4)) brightness += pixel.mean;
  EXPECT_GT(brightness, 240 * 0.005);  // there is light
  expect_same_expectation(*clustered, *truth, 128);
}

const std::string kPhong = phong_xml("20");
const std::string kWard = ward_xml(".1");
const std::string kMetal = metal_xml(".25");
const std::string kRoughPlastic =
    R"(<bsdf type="roughplastic"><float name="alpha" value=".2"/></bsdf>)";
const std::string kMirror = R"(<bsdf type="conductor"/>)";
const std::string kTwoSided =
    R"(<bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value=".3"/></bsdf></bsdf>)";
const std::string kSmall = counts_xml(30, 16);
const std::string kJoint = kSmall + importance_xml("joint");
const std::string kLuminance = kSmall + importance_xml("luminance");
const std::string kBrdf = kSmall + importance_xml("brdf");
const std::string kOldCut = kJoint + kLuminanceCut;
const std::string kOneCluster = counts_xml(1, 32);
const std::string kTraced =
    std::string(R"(<emitter type="vpl"><string name="placement" value="traced"/>)") + kSpot +
    "</emitter>";

INSTANTIATE_TEST_SUITE_P(
    Modes, LocalAgainstGroundTruth,
    testing::Values(Case{"DiffuseJoint", kDiffuse, kJoint},
                    Case{"DiffuseLuminance", kDiffuse, kLuminance},
                    Case{"DiffuseBrdf", kDiffuse, kBrdf}, Case{"PhongJoint", kPhong, kJoint},
                    Case{"PhongLuminance", kPhong, kLuminance}, Case{"PhongBrdf", kPhong, kBrdf},
                    Case{"WardJoint", kWard, kJoint}, Case{"WardLuminance", kWard, kLuminance},
                    Case{"WardBrdf", kWard, kBrdf}, Case{"MetalJoint", kMetal, kJoint},
                    Case{"RoughPlasticOldCut", kRoughPlastic, kOldCut},
                    Case{"RoughPlasticTwoSided", kTwoSided, kJoint},
                    Case{"Mirror", kMirror, kJoint}, Case{"OneCluster", kPhong, kOneCluster},
                    Case{"Traced", kPhong, kJoint, kTraced},
                    Case{"SkyAndTwoLamps", kPhong, kJoint, std::string(kSpot) + kPoint + kSky},
                    Case{"LocalAlone", kPhong, kJoint + R"(<string name="mode" value="local"/>)",
                         std::string(kSpot) + kSky},
                    Case{"Sobol", kWard, kJoint, kSpot, sampler_xml("sobol")}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace kinome::test::local_clustered_test

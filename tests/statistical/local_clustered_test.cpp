// `clustered` over virtual point lights, in every mode, estimates what `groundtruth` computes from
// the same points: renders of one seed have the same points and the same places in the pixels, so
// that their difference has mean 0, and z-tests see little else than the choice of points.
#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome {
namespace {

/// A room that a spot lights by way of a wall, with a curved and a flat object in it.
std::unique_ptr<Scene> room(const std::string& integrator, const std::string& bsdf,
                            const std::string& more, const std::string& sampler) {
  const auto wall = [](const char* placement, const char* color) {
    return std::string("<shape type=\"rectangle\"><transform name=\"to_world\">") + placement +
           "</transform><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"" + color +
           "\"/></bsdf></shape>";
  };
  return test::scene_from(
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
  const char* bsdf;
  std::string parameters;
  std::string more = kSpot;
  const char* sampler =
      R"(<sampler type="independent"><integer name="sample_count" value="4"/></sampler>)";
};

constexpr const char* kDiffuse =
    R"(<bsdf type="diffuse"><rgb name="reflectance" value=".7 .5 .3"/></bsdf>)";
constexpr const char* kPhong =
    R"(<bsdf type="phong"><rgb name="diffuse_reflectance" value=".3 .2 .4"/>
    <rgb name="specular_reflectance" value=".4 .4 .2"/><float name="exponent" value="20"/></bsdf>)";
constexpr const char* kWard =
    R"(<bsdf type="ward"><rgb name="diffuse_reflectance" value=".3 .2 .1"/>
    <rgb name="specular_reflectance" value=".3 .4 .5"/>
    <float name="alpha_u" value=".1"/><float name="alpha_v" value=".3"/></bsdf>)";
constexpr const char* kMetal =
    R"(<bsdf type="roughconductor"><float name="alpha" value=".25"/></bsdf>)";
constexpr const char* kRoughPlastic =
    R"(<bsdf type="roughplastic"><float name="alpha" value=".2"/></bsdf>)";
constexpr const char* kMirror = R"(<bsdf type="conductor"/>)";
constexpr const char* kTwoSided =
    R"(<bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value=".3"/></bsdf></bsdf>)";

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
  for (const test::Estimate& pixel : test::estimate_pixels(*truth, 4)) brightness += pixel.mean;
  EXPECT_GT(brightness, 240 * 0.005);  // there is light
  const auto difference = test::estimate_differences(*clustered, *truth, 128, 4);
  const test::Verdict verdict =
      test::z_test(difference, std::vector<test::Estimate>(difference.size()), 1e-4);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

const std::string kSmall =
    R"(<integer name="cut_size" value="30"/><integer name="emitter_samples" value="16"/>)";
const std::string kJoint = kSmall + R"(<string name="importance" value="joint"/>)";
const std::string kLuminance = kSmall + R"(<string name="importance" value="luminance"/>)";
const std::string kBrdf = kSmall + R"(<string name="importance" value="brdf"/>)";
const std::string kOldCut = kJoint + R"(<string name="cut_criterion" value="luminance"/>)";
const std::string kOneCluster =
    R"(<integer name="cut_size" value="1"/><integer name="emitter_samples" value="32"/>)";
const std::string kTraced =
    std::string(R"(<emitter type="vpl"><string name="placement" value="traced"/>)") + kSpot +
    "</emitter>";

INSTANTIATE_TEST_SUITE_P(
    Modes, LocalAgainstGroundTruth,
    testing::Values(
        Case{"DiffuseJoint", kDiffuse, kJoint}, Case{"DiffuseLuminance", kDiffuse, kLuminance},
        Case{"DiffuseBrdf", kDiffuse, kBrdf}, Case{"PhongJoint", kPhong, kJoint},
        Case{"PhongLuminance", kPhong, kLuminance}, Case{"PhongBrdf", kPhong, kBrdf},
        Case{"WardJoint", kWard, kJoint}, Case{"WardLuminance", kWard, kLuminance},
        Case{"WardBrdf", kWard, kBrdf}, Case{"MetalJoint", kMetal, kJoint},
        Case{"RoughPlasticOldCut", kRoughPlastic, kOldCut},
        Case{"RoughPlasticTwoSided", kTwoSided, kJoint}, Case{"Mirror", kMirror, kJoint},
        Case{"OneCluster", kPhong, kOneCluster}, Case{"Traced", kPhong, kJoint, kTraced},
        Case{"SkyAndTwoLamps", kPhong, kJoint, std::string(kSpot) + kPoint + kSky},
        Case{"LocalAlone", kPhong, kJoint + R"(<string name="mode" value="local"/>)",
             std::string(kSpot) + kSky},
        Case{"Sobol", kWard, kJoint, kSpot,
             R"(<sampler type="sobol"><integer name="sample_count" value="4"/></sampler>)"}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace kinome

// `clustered` in every mode estimates what `groundtruth` computes from the same light points:
// z-tests over pixels and over their sum. The light is harsh on purpose: two suns on a dim,
// coloured sky.
#include <gtest/gtest.h>

#include "kinome/image.h"
#include "support/render.h"

namespace kinome {
namespace {

/// A 64x32 environment with two bright spots of unequal colour, one of them low, and one negative
/// texel, as photographs have.
class Sky {
 public:
  Sky() {
    Image image;
    image.width = 64;
    image.height = 32;
    image.channels = {"R", "G", "B"};
    image.data.resize(3 * 64 * 32);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        const float shade = 0.2f + 0.1f * std::sin(0.3f * static_cast<float>(x + 2 * y));
        set(image, x, y, Rgb(shade, 0.9f * shade, 1.2f * shade));
      }
    }
    set(image, 20, 9, Rgb(90, 80, 40));
    set(image, 45, 14, Rgb(5, 20, 60));
    set(image, 5, 5, Rgb(-0.01f));
    path_ = folder_.path("sky.exr");
    write_exr(path_, image, false, {});
  }
  const std::string& path() const { return path_; }

 private:
  static void set(Image& image, int x, int y, const Rgb& value) {
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = value[c];
  }
  test::TemporaryFolder folder_;
  std::string path_;
};

const Sky& sky() {
  static const Sky instance;
  return instance;
}

/// A sphere over a floor, of one material: shadows, grazing angles and horizons that cut clusters.
std::unique_ptr<Scene> make_scene(const std::string& integrator, const std::string& bsdf,
                                  const std::string& sampler) {
  return test::scene_from(R"(<scene version="3.0.0">)" + integrator + R"(
    <sensor type="perspective">
      <float name="fov" value="45"/>
      <transform name="to_world"><lookat origin="0,2,5" target="0,.4,0" up="0,1,0"/></transform>
      )" + sampler + R"(
      <film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="10"/>
        <rfilter type="box"/></film>
    </sensor>
    <shape type="sphere"><point name="center" x="0" y=".8" z="0"/><float name="radius" value=".8"/>)" +
                          bsdf + R"(</shape>
    <shape type="rectangle">
      <transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>)" +
                          bsdf + R"(</shape>
    <emitter type="envmap"><string name="filename" value=")" +
                          sky().path() + R"("/></emitter></scene>)");
}

struct Case {
  const char* name;
  const char* bsdf;
  const char* parameters;
  const char* sampler =
      R"(<sampler type="independent"><integer name="sample_count" value="4"/></sampler>)";
};

constexpr const char* kDiffuse =
    R"(<bsdf type="diffuse"><rgb name="reflectance" value=".7 .5 .3"/></bsdf>)";
constexpr const char* kPhong =
    R"(<bsdf type="phong"><rgb name="diffuse_reflectance" value=".3 .2 .4"/>
    <rgb name="specular_reflectance" value=".4 .4 .2"/><float name="exponent" value="40"/></bsdf>)";
constexpr const char* kWard =
    R"(<bsdf type="ward"><rgb name="diffuse_reflectance" value=".3 .2 .1"/>
    <rgb name="specular_reflectance" value=".3 .4 .5"/>
    <float name="alpha_u" value=".08"/><float name="alpha_v" value=".3"/></bsdf>)";
constexpr const char* kMetal =
    R"(<bsdf type="roughconductor"><float name="alpha" value=".2"/></bsdf>)";

class ClusteredAgainstGroundTruth : public testing::TestWithParam<Case> {};

TEST_P(ClusteredAgainstGroundTruth, HasItsExpectation) {
  const Case& c = GetParam();
  const std::string points = R"(<integer name="light_samples" value="512"/>)";
  const auto truth = make_scene(R"(<integrator type="groundtruth">)" + points + "</integrator>",
                                c.bsdf, c.sampler);
  const auto clustered =
      make_scene(R"(<integrator type="clustered">)" + points + c.parameters + "</integrator>",
                 c.bsdf, c.sampler);
  // Both have the same places in their pixels: what is left are the choices of `clustered`.
  const auto difference = test::estimate_differences(*clustered, *truth, 96, 4);
  const test::Verdict verdict =
      test::z_test(difference, std::vector<test::Estimate>(difference.size()), 1e-4);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

constexpr const char* kSmall =
    R"(<integer name="cut_size" value="40"/><integer name="emitter_samples" value="12"/>)";
const std::string kJoint = std::string(kSmall) + R"(<string name="importance" value="joint"/>)";
const std::string kLuminance =
    std::string(kSmall) + R"(<string name="importance" value="luminance"/>)";
const std::string kBrdf = std::string(kSmall) + R"(<string name="importance" value="brdf"/>)";
const std::string kOldCut = kJoint + R"(<string name="cut_criterion" value="luminance"/>)";
const std::string kNoLobe = kJoint + R"(<integer name="brdf_samples" value="0"/>)";
constexpr const char* kOneCluster =
    R"(<integer name="cut_size" value="1"/><integer name="emitter_samples" value="64"/>)";

INSTANTIATE_TEST_SUITE_P(
    Modes, ClusteredAgainstGroundTruth,
    testing::Values(
        Case{"DiffuseJoint", kDiffuse, kJoint.c_str()},
        Case{"DiffuseLuminance", kDiffuse, kLuminance.c_str()},
        Case{"DiffuseBrdf", kDiffuse, kBrdf.c_str()}, Case{"PhongJoint", kPhong, kJoint.c_str()},
        Case{"PhongLuminance", kPhong, kLuminance.c_str()},
        Case{"PhongBrdf", kPhong, kBrdf.c_str()}, Case{"PhongNoLobeRays", kPhong, kNoLobe.c_str()},
        Case{"WardJoint", kWard, kJoint.c_str()}, Case{"WardLuminance", kWard, kLuminance.c_str()},
        Case{"WardBrdf", kWard, kBrdf.c_str()}, Case{"WardLuminanceCut", kWard, kOldCut.c_str()},
        Case{"MetalJoint", kMetal, kJoint.c_str()}, Case{"MetalBrdf", kMetal, kBrdf.c_str()},
        Case{"OneCluster", kPhong, kOneCluster},
        Case{"Sobol", kWard, kJoint.c_str(),
             R"(<sampler type="sobol"><integer name="sample_count" value="4"/></sampler>)"},
        Case{"Halton", kPhong, kJoint.c_str(),
             R"(<sampler type="halton"><integer name="sample_count" value="4"/></sampler>)"},
        Case{"Stratified", kDiffuse, kJoint.c_str(),
             R"(<sampler type="stratified"><integer name="sample_count" value="4"/></sampler>)"}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace kinome

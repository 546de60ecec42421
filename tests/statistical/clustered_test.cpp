// Tests that `clustered` in every mode estimates the result of `groundtruth` from the same light
// points, by z-tests over pixels and over their sum. The light is difficult: two suns on a dim,
// coloured sky.
#include <gtest/gtest.h>

#include "clustered_cases.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::clustered_test {
namespace {

/// A 64x32 environment with two bright spots of different colours, one of them low. One texel is
/// negative, as in photographs.
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
    write_exr(path_, image, ExrSampleType::kFloat, {});
  }
  const std::string& path() const { return path_; }

 private:
  static void set(Image& image, int x, int y, const Rgb& value) {
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = value[c];
  }
  TemporaryFolder folder_;
  std::string path_;
};

const Sky& sky() {
  static const Sky instance;
  return instance;
}

/// A sphere over a floor, of one material: shadows, grazing angles, and clusters partly below the
/// horizon.
std::unique_ptr<Scene> make_scene(const std::string& integrator, const std::string& bsdf,
                                  const std::string& sampler) {
  return scene_from(R"(<scene version="3.0.0">)" + integrator + R"(
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
  std::string bsdf;
  std::string parameters;
  std::string sampler = sampler_xml("independent");
  int renders = 96;
};

class ClusteredAgainstGroundTruth : public testing::TestWithParam<Case> {};

TEST_P(ClusteredAgainstGroundTruth, HasItsExpectation) {
  const Case& c = GetParam();
  const std::string points =
      R"(<integer name="light_samples" value="512"/><integer name="max_depth" value="2"/>)";
  const auto truth = make_scene(R"(<integrator type="groundtruth">)" + points + "</integrator>",
                                c.bsdf, c.sampler);
  const auto clustered =
      make_scene(R"(<integrator type="clustered">)" + points + c.parameters + "</integrator>",
                 c.bsdf, c.sampler);
  expect_same_expectation(*clustered, *truth, c.renders);
}

const std::string kPhong = phong_xml("40");
const std::string kWard = ward_xml(".08");
const std::string kMetal = metal_xml(".2");
const std::string kSmall = counts_xml(40, 12);
const std::string kJoint = kSmall + importance_xml("joint");
const std::string kLuminance = kSmall + importance_xml("luminance");
const std::string kBrdf = kSmall + importance_xml("brdf");
const std::string kOldCut = kJoint + kLuminanceCut;
const std::string kNoLobe = kJoint + R"(<integer name="brdf_samples" value="0"/>)";
const std::string kOneCluster = counts_xml(1, 64) + importance_xml("joint");

INSTANTIATE_TEST_SUITE_P(
    Modes, ClusteredAgainstGroundTruth,
    testing::Values(
        Case{"DiffuseJoint", kDiffuse, kJoint}, Case{"DiffuseLuminance", kDiffuse, kLuminance},
        Case{"DiffuseBrdf", kDiffuse, kBrdf}, Case{"PhongJoint", kPhong, kJoint},
        Case{"PhongLuminance", kPhong, kLuminance}, Case{"PhongBrdf", kPhong, kBrdf},
        Case{"PhongNoLobeRays", kPhong, kNoLobe}, Case{"WardJoint", kWard, kJoint},
        Case{"WardLuminance", kWard, kLuminance}, Case{"WardBrdf", kWard, kBrdf},
        Case{"WardLuminanceCut", kWard, kOldCut}, Case{"MetalJoint", kMetal, kJoint},
        // Rare samples of the sun are most of the light: 96 renders probably contain none of them.
        Case{"MetalBrdf", kMetal, kBrdf, sampler_xml("independent"), 1536},
        Case{"OneCluster", kPhong, kOneCluster}, Case{"Sobol", kWard, kJoint, sampler_xml("sobol")},
        Case{"Halton", kPhong, kJoint, sampler_xml("halton")},
        Case{"Stratified", kDiffuse, kJoint, sampler_xml("stratified")}),
    [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace kinome::test::clustered_test

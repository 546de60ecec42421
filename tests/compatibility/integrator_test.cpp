/// Scenes without an integrator, or without a maximum path depth.
#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test::integrator_test {
namespace {

/// Two diffuse walls of a corner under a small lamp: much of the light takes several bounces.
const std::string kCorner =
    "<sensor type=\"perspective\"><transform name=\"to_world\"><lookat origin=\"3,2,3\" "
    "target=\"0,0.5,0\" up=\"0,1,0\"/></transform><film type=\"hdrfilm\">"
    "<integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"8\"/></film></sensor>"
    "<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"true\"/>"
    "<transform name=\"to_world\"><scale value=\"4\"/></transform>"
    "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.8\"/></bsdf></shape>"
    "<shape type=\"sphere\"><emitter type=\"area\"/></shape>";

TEST(NoIntegrator, IsPathWithOneWarning) {
  testing::internal::CaptureStderr();
  const auto scene = scene_from(kCorner);
  const std::string messages = testing::internal::GetCapturedStderr();
  const std::string expected = "the scene has no integrator: using 'path'";
  const size_t at = messages.find(expected);
  ASSERT_NE(at, std::string::npos) << messages;
  EXPECT_EQ(messages.find(expected, at + 1), std::string::npos) << messages;
  EXPECT_EQ(scene->integrator().plugin(), "integrator/path");
  EXPECT_EQ(render_scene(*scene).data,
            render_scene(*scene_from("<integrator type=\"path\"/>" + kCorner)).data);
}

/// `-D integrator=path` renders the same image as Python's `integrator="path"`.
TEST(ScenesIntegrators, HaveAllBouncesByDefault) {
  for (const std::string& type : std::vector<std::string>{"path", "ptracer", "clustered"}) {
    const std::string included = "<include filename=\"" + std::string(KINOME_TEST_SOURCE) +
                                 "/scenes/integrators/" + type + ".xml\"/>";
    const std::string own = "<integrator type=\"" + type + "\"/>";
    EXPECT_EQ(render_scene(*scene_from(included + kCorner)).data,
              render_scene(*scene_from(own + kCorner)).data)
        << type;
  }
}

}  // namespace
}  // namespace kinome::test::integrator_test

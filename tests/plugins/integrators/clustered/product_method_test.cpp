// Tests which scenes `importance` = product renders, and which it leaves to light points.
#include "clustered/product/method/product_method.h"

#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test::product_method_test {
namespace {

bool is_served(const std::string& lights, uint32_t max_depth = 2, float max_geometry_term = 0) {
  const auto scene = scene_from(
      "<integrator type=\"clustered\"><integer name=\"max_depth\" value=\"" +
      std::to_string(max_depth) +
      "\"/></integrator><sensor type=\"perspective\"/><shape type=\"sphere\"/>" + lights);
  RenderContext context(RenderOptions{.threads = 1});
  ProductMethod::Settings settings;
  settings.sampling.length.max_depth = max_depth;
  settings.cells = 32;
  settings.max_geometry_term = max_geometry_term;
  return ProductMethod::make(settings, *scene, *scene->sensors().front(), context) != nullptr;
}

const std::string kSky = R"(<emitter type="constant"/>)";
const std::string kBlackSky =
    R"(<emitter type="constant"><rgb name="radiance" value="0 0 0"/></emitter>)";
const std::string kLamp =
    R"(<emitter type="point"><point name="position" value="0, 3, 0"/></emitter>)";
const std::string kBounce = R"(<emitter type="vpl"/>)";

TEST(ProductMethod, ServesSkyAndLamps) {
  EXPECT_TRUE(is_served(kSky));
  EXPECT_TRUE(is_served(kLamp));
  EXPECT_TRUE(is_served(kSky + kLamp, 3));
  EXPECT_TRUE(is_served(kLamp + kBounce, 3));
}

TEST(ProductMethod, LeavesDarkScenesToOthers) {
  EXPECT_FALSE(is_served(""));
  EXPECT_FALSE(is_served(kBlackSky));
  EXPECT_TRUE(is_served(kBlackSky + kLamp));
}

/// Only light points support a bounce of selected emitters, and a bounded geometry term.
TEST(ProductMethod, LeavesUnsupportedScenesToLightPoints) {
  EXPECT_FALSE(is_served(kLamp, 3, 10));
  EXPECT_TRUE(is_served(kLamp, 2, 10)) << "there is no bounce to be bounded";
  EXPECT_FALSE(is_served(R"(<emitter type="vpl">)" + kLamp + "</emitter>", 3));
}

}  // namespace
}  // namespace kinome::test::product_method_test

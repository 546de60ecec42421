// `clustered` with importance = product at the limits of single precision.
#include <gtest/gtest.h>

#include <cmath>

#include "clustered/product/method/product_method.h"
#include "render/paths/path_scenes.h"
#include "product_scenes.h"

namespace kinome::test::product_extremes_test {
namespace {

Arrangement arranged(const std::string& light, int max_depth, const std::string& shapes) {
  Arrangement setup;
  setup.light = light;
  setup.max_depth = max_depth;
  setup.shapes = shapes;
  return setup;
}

/// The largest roughness that is accepted. kinome-stress once found that squared roughnesses
/// overflowed.
TEST(ProductExtremes, VastRoughnessIsFinite) {
  for (const char* alpha : {"1e3", "1e6"}) {
    const std::string metal =
        bsdf("roughconductor", "<float name=\"alpha\" value=\"" + std::string(alpha) + "\"/>");
    const auto scene = product_scene(
        arranged(constant_xml("1 1 1") + point_xml("2,3,2", "30 25 20"), 3,
                 shapes_xml(metal) +
                     shape_xml("rectangle", "<scale value=\"6\"/><translate z=\"-3\"/>", kGrey)));
    RenderContext context({});
    const Image image = render(*scene, *scene->sensors().at(0), context);
    EXPECT_EQ(context.job.stats().non_finite_samples, 0u) << alpha;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) EXPECT_TRUE(std::isfinite(image.at(x, y, 1))) << alpha;
    }
  }
}

/// `product` renders a scene only if single precision can represent the flux of light paths. Direct
/// light of a sky or a lamp needs no light paths.
TEST(ProductExtremes, VastFluxIsLeftToOthers) {
  const auto serves = [](const std::string& light, int max_depth) {
    // The sky's flux is proportional to the area of the whole scene.
    const std::string far_off =
        "<shape type=\"sphere\"><point name=\"center\" value=\"3e11 0 0\"/>"
        "<float name=\"radius\" value=\"1e11\"/></shape>";
    const auto scene = product_scene(arranged(light, max_depth, shapes_xml(kGrey) + far_off));
    ProductMethod::Settings settings;
    settings.sampling.length.max_depth = static_cast<uint32_t>(max_depth);
    return ProductMethod::serves(settings, *scene);
  };
  EXPECT_TRUE(serves(constant_xml("1"), 3));
  EXPECT_TRUE(serves(constant_xml("1e19"), 2));
  EXPECT_FALSE(serves(constant_xml("1e19"), 3));
  EXPECT_TRUE(serves(point_xml("0,2,0", "1e35"), 2));
  EXPECT_FALSE(serves(point_xml("0,2,0", "1e35"), 3));
  const auto panel = [](const char* radiance) {
    return shape_xml("rectangle", "<scale value=\"1e3\"/><translate y=\"3\"/>", area_xml(radiance));
  };
  EXPECT_TRUE(serves(panel("1e20"), 2));
  EXPECT_FALSE(serves(panel("1e33"), 2));
}

}  // namespace
}  // namespace kinome::test::product_extremes_test

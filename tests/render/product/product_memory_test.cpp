// The memory limit for large images doesn't change the result.
#include <gtest/gtest.h>

#include "clustered/product/method/product_method.h"
#include "kinome/clustered_light.h"
#include "product_scenes.h"

namespace kinome::test::product_memory_test {
namespace {

/// Renders three rows of blocks, the last of which is narrow, in passes of different sizes. The
/// scene has a sky, a lamp and a bounce.
Image rendered(int remembered_pixels) {
  Arrangement s;
  s.light += R"(<emitter type="point"><point name="position" x="0" y="1.5" z="2"/></emitter>)";
  s.film = integer("width", 36) + integer("height", 70) + "<rfilter type=\"box\"/>";
  const auto scene = product_scene(s);
  const Sensor& sensor = *scene->sensors().front();
  RenderContext context({.threads = 2, .seed = 3});
  ProductSettings settings;
  settings.rays_per_pixel = 600;
  settings.length.max_depth = 3;
  settings.remembered_pixels = remembered_pixels;
  settings.trial = false;
  sensor.film().prepare(scene->integrator().layers());
  const Emitter& sky = *scene->environment();
  auto cells =
      std::make_shared<const DistantCells>(sky, *cell_grid_of(sky), 128, context.scheduler);
  ProductMethod(settings, [&] { return cells; }).render(*scene, sensor, context);
  return sensor.film().develop();
}

TEST(ProductMemory, LearningInBandsGivesTheSameImage) {
  const Image all = rendered(36 * 70);
  for (const int pixels : {0, 36 * 32, 36 * 64}) {
    EXPECT_EQ(rendered(pixels).data, all.data) << pixels << " pixels";
  }
}

}  // namespace
}  // namespace kinome::test::product_memory_test

// A render that is interrupted, at whatever place: what has no samples yet gets one, by integrators
// that go tile by tile, block by block, and have set-up. Time stands still here, as else what is
// quick were a matter of the machine.
#include <gtest/gtest.h>

#include <atomic>

#include "product_scenes.h"

namespace kinome::test {
namespace {

constexpr int kAcross = 3, kDown = 2;
constexpr double kTile = 1. / (kAcross * kDown);

std::unique_ptr<Scene> scene_of(const std::string& integrator, const std::string& parameters) {
  Arrangement s;
  s.light +=
      "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"1.5\" z=\"2\"/>"
      "<rgb name=\"intensity\" value=\"5\"/></emitter>";
  s.film = integer("width", kAcross * kTileSize) + integer("height", kDown * kTileSize) +
           "<rfilter type=\"box\"/>";
  return make_scene(s, "<integrator type=\"" + integrator + "\">" + parameters + "</integrator>",
                    4);
}

/// When progress is told for the `end`-th time; it is told for each tile or block.
Image interrupted(const Scene& scene, int end, RenderStats& stats) {
  std::atomic<bool> cancel{false};
  int told = 0;
  RenderContext context({.threads = 1,
                         .cancel = &cancel,
                         .progress = [&](double) { cancel = ++told == end; },
                         .clock = [] { return 1.; }});
  Image image = render(scene, *scene.sensors()[0], context);
  stats = context.stats();
  return image;
}

/// The sky is everywhere.
int dark_pixels(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += image.at(x, y, 0) == 0;
  }
  return count;
}

/// `before`: places at which nothing is in the picture yet.
void expect_filled_anywhere(const Scene& scene, int before) {
  double filled = 1;
  int end = 1;
  for (; filled > 0 && end <= 100; ++end) {
    SCOPED_TRACE(end);
    RenderStats stats;
    const Image image = interrupted(scene, end, stats);
    EXPECT_FALSE(stats.complete);
    EXPECT_EQ(stats.missing, 0);
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_LT(dark_pixels(image), 0.5 * kTileSize * kTileSize);
    if (end > before) filled -= kTile;
    EXPECT_NEAR(stats.filled, filled, 1e-9);
    filled = stats.filled;
  }
  EXPECT_EQ(filled, 0);
}

TEST(InterruptedRender, TileByTile) {
  for (const char* integrator : {"direct", "path"}) {
    SCOPED_TRACE(integrator);
    expect_filled_anywhere(*scene_of(integrator, ""), 0);
  }
  expect_filled_anywhere(*scene_of("groundtruth", integer("light_samples", 64)), 0);
}

TEST(InterruptedRender, ClusteredByLightPoints) {
  expect_filled_anywhere(
      *scene_of("clustered", "<string name=\"importance\" value=\"joint\"/>" +
                                 integer("emitter_samples", 4) + integer("light_samples", 1024)),
      0);
}

TEST(InterruptedRender, ClusteredBeforeAndAfterItsPilot) {
  // The pilot looks at all blocks, and then learns from all.
  const int blocks = kAcross * kDown;
  for (const int depth : {2, 3}) {
    SCOPED_TRACE(depth);
    expect_filled_anywhere(
        *scene_of("clustered",
                  "<boolean name=\"trial\" value=\"false\"/>" + integer("max_depth", depth)),
        2 * blocks);
  }
}

}  // namespace
}  // namespace kinome::test

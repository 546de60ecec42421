// Tests renders that are interrupted at any position: each pixel without samples gets one. The
// integrators render tile by tile, block by block, or with a set-up. The clock is stopped, because
// the set of fast integrators would otherwise depend on the machine.
#include <gtest/gtest.h>

#include <atomic>

#include "render/product/product_scenes.h"

namespace kinome::test::interrupted_test {
namespace {

constexpr int kAcross = 3, kDown = 2;
constexpr double kTile = 1. / (kAcross * kDown);

std::unique_ptr<Scene> scene_of(const std::string& integrator, const std::string& parameters) {
  Arrangement s;
  s.light +=
      "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"1.5\" z=\"2\"/>"
      "<rgb name=\"intensity\" value=\"5\"/></emitter>";
  s.film = integer("width", kAcross * kSmallTileSize) + integer("height", kDown * kSmallTileSize) +
           "<rfilter type=\"box\"/>";
  return make_scene(s, "<integrator type=\"" + integrator + "\">" + parameters + "</integrator>",
                    4);
}

/// Interrupts the render at the `end`-th progress report; there is one for each tile or block.
Image interrupted(const Scene& scene, int end, RenderStats& stats) {
  std::atomic<bool> cancel{false};
  int num_reports = 0;
  RenderContext context({.threads = 1,
                         .cancel = &cancel,
                         .progress = [&](double) { cancel = ++num_reports == end; },
                         .clock = [] { return 1.; }});
  Image image = render(scene, *scene.sensors()[0], context);
  stats = context.job.stats();
  return image;
}

/// The sky covers the whole image, so that a dark pixel has no sample.
int dark_pixels(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += image.at(x, y, 0) == 0;
  }
  return count;
}

/// `before`: number of interruptions before the first sample is in the image.
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
    EXPECT_LT(dark_pixels(image), 0.5 * kSmallTileSize * kSmallTileSize);
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
  // The pilot traces all blocks, and then learns from all of them.
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
}  // namespace kinome::test::interrupted_test

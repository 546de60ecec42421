// Passes of the viewer's progressive render, with a simulated clock.
#include "session/live_render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <vector>

#include "support/render.h"

namespace kinome::test::live_render_test {
namespace {

constexpr double kMaxSamples = 64;

/// A sphere under an even sky, in sixteen tiles of the image.
struct Live {
  std::unique_ptr<Scene> scene = scene_from(R"(
    <integrator type="path"/>
    <sensor type="perspective">
      <transform name="to_world">
        <lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/>
      </transform>
      <film type="hdrfilm">
        <integer name="width" value="64"/>
        <integer name="height" value="64"/>
        <rfilter type="box"/>
      </film>
    </sensor>
    <emitter type="constant"/>
    <shape type="sphere"><bsdf type="diffuse"/></shape>)");
  std::atomic<double> now = 0;
  double seconds_per_call = 0;  ///< advance of the clock when it is read
  std::atomic<bool> cancel = false;
  RenderContext context{{.threads = 2, .seed = 1, .cancel = &cancel, .clock = [this] {
                           return now.fetch_add(seconds_per_call);
                         }}};
  viewer::LiveRender render{*scene, *scene->sensors().front(), context, kMaxSamples};

  /// True if all pixels have light, and thus samples.
  static bool is_lit(const Image& image) {
    return std::ranges::all_of(image.data, [](float value) { return value > 0; });
  }
};

TEST(LiveRender, PassesGrowWithTheNumberOfSamples) {
  Live live;
  for (const double total : {1., 9., 25., 57., kMaxSamples}) {
    ASSERT_TRUE(live.render.pass());
    EXPECT_EQ(live.render.samples(), total);
  }
}

TEST(LiveRender, EstimatesTheErrorOnceAllLanesHaveSamples) {
  Live live;
  EXPECT_EQ(live.render.rel_mse(), -1);
  for (int pass = 1; pass <= 4; ++pass) {
    ASSERT_TRUE(live.render.pass());
    EXPECT_EQ(live.render.rel_mse() > 0, pass == 4) << pass;
  }
}

TEST(LiveRender, GivesImagesWithFinishedTilesDuringAPass) {
  Live live;
  live.seconds_per_call = 0.1;
  std::vector<Image> images;
  const auto keep = [&](Image image) { images.push_back(std::move(image)); };
  ASSERT_TRUE(live.render.pass(std::nullopt, keep));
  EXPECT_TRUE(images.empty()) << "the first pass leaves pixels without samples";
  const Image before = live.render.develop();
  ASSERT_TRUE(live.render.pass(std::nullopt, keep));
  const Image after = live.render.develop();
  ASSERT_FALSE(images.empty());
  for (const Image& image : images) {
    // Each pixel is that of one of the two images.
    EXPECT_NE(image.data, before.data);
    EXPECT_NE(image.data, after.data);
    for (size_t i = 0; i < image.data.size(); ++i) {
      EXPECT_TRUE(image.data[i] == before.data[i] || image.data[i] == after.data[i]);
    }
  }
}

TEST(LiveRender, SurvivesTheInterruptionOfAnyPassButTheFirst) {
  Live live;
  live.seconds_per_call = 0.1;
  ASSERT_TRUE(live.render.pass());
  const Image first = live.render.develop();
  EXPECT_FALSE(live.render.pass(std::nullopt, [&](const Image&) { live.cancel = true; }));
  EXPECT_TRUE(live.render.is_whole());
  EXPECT_EQ(live.render.samples(), 1);
  const Image part = live.render.develop();
  EXPECT_NE(part.data, first.data);
  EXPECT_TRUE(Live::is_lit(part));
  live.cancel = false;
  live.seconds_per_call = 0;
  for (const double total : {9., 25., 57.}) {
    ASSERT_TRUE(live.render.pass());
    EXPECT_EQ(live.render.samples(), total);
  }
  EXPECT_GT(live.render.rel_mse(), 0);

  Live interrupted;
  interrupted.cancel = true;
  EXPECT_FALSE(interrupted.render.pass());
  EXPECT_FALSE(interrupted.render.is_whole());
}

TEST(LiveRender, RestrictsLaterPassesToARegion) {
  Live live;
  const Rect region{16, 16, 32, 32};
  ASSERT_TRUE(live.render.pass(region));
  ASSERT_TRUE(live.render.pass(region));
  const Image whole = live.render.develop();
  EXPECT_TRUE(Live::is_lit(whole));
  ASSERT_TRUE(live.render.pass(region));
  const Image image = live.render.develop();
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) EXPECT_EQ(image.at(x, y, 0), whole.at(x, y, 0));
  }
  EXPECT_NE(image.data, whole.data);
  EXPECT_EQ(live.render.rel_mse(), -1);
}

}  // namespace
}  // namespace kinome::test::live_render_test

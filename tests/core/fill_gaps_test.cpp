// Tests how an interrupted render fills pixels without samples. They get one sample each if that is
// fast enough, measured by a clock that advances as the render works.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "support/render.h"

namespace kinome::test::fill_gaps_test {
namespace {

constexpr int kTiles = 4;

/// Time in seconds that each step of the test integrator takes.
struct Pace {
  double light_left_out = 0;
  double set_up = 0;  ///< of the render
  double set_up_to_fill = 0;
  double sample = 0;  ///< one sample of all pixels
};

class PacedIntegrator : public Integrator {
 public:
  PacedIntegrator(const Pace& pace, double& now) : pace_(pace), now_(now) {}
  std::vector<std::vector<std::string>> layers() const override { return {{}}; }
  void warn_of_ignored_light(const Scene&, const Sensor&, RenderContext&) const override {
    now_ += pace_.light_left_out;
  }
  void render(const Scene&, const Sensor& sensor, RenderContext& context) const override {
    const uint32_t samples = sensor.sampler().sample_count();
    now_ += samples == 1 ? pace_.set_up_to_fill : pace_.set_up;
    context.scheduler.for_each_tile(sensor.film(), [&](Tile& tile) {
      for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
        for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
          tile.film.add({x + 0.5f, y + 0.5f}, std::vector<float>{1, 1, 1});
        }
      }
      tile.counters[RayKind::kCamera] += uint64_t{samples} * tile.pixels.area();
      now_ += samples * pace_.sample / kTiles;
    });
  }

 private:
  const Pace pace_;
  double& now_;
};

/// Cancels the render when the first of four tiles is done.
RenderStats interrupted(const Pace& pace) {
  double now = 0;
  std::atomic<bool> cancel{false};
  Scene::Contents contents;
  contents.integrator = std::make_shared<PacedIntegrator>(pace, now);
  contents.sensors = {make<Sensor>(
      "<sensor type=\"perspective\"><sampler type=\"independent\"><integer name=\"sample_count\" "
      "value=\"16\"/></sampler><film type=\"hdrfilm\"><integer name=\"width\" value=\"" +
      std::to_string(kTiles * kSmallTileSize) + "\"/><integer name=\"height\" value=\"" +
      std::to_string(kSmallTileSize) + "\"/><rfilter type=\"box\"/></film></sensor>")};
  const Scene scene(contents, 1);
  RenderContext context({.threads = 1,
                         .cancel = &cancel,
                         .progress = [&](double) { cancel = true; },
                         .clock = [&] { return now; }});
  const Image image = render(scene, *scene.sensors()[0], context);
  const RenderStats& stats = context.job.stats();
  EXPECT_FALSE(stats.complete);
  EXPECT_EQ(stats.first_tile_seconds, pace.light_left_out + pace.set_up);
  // Missing pixels are marked, and no others.
  const bool is_marked = stats.missing > 0;
  EXPECT_EQ(image.channels.size(), is_marked ? 4u : 3u);
  int missing = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float value = image.at(x, y, 0);
      missing += value == 0;
      if (is_marked) {
        EXPECT_EQ(image.at(x, y, 3), value) << x << " " << y;
      }
    }
  }
  EXPECT_EQ(stats.missing, missing / (kTiles * sqr(static_cast<double>(kSmallTileSize))));
  return stats;
}

TEST(FillGaps, QuickPixelsAreFilled) {
  for (const Pace& pace : {Pace{0, 0, 0, 0}, Pace{0, 1.9, 0, .1}, Pace{0, 0, 0, 2.6}}) {
    const RenderStats stats = interrupted(pace);
    EXPECT_EQ(stats.filled, 0.75);
    EXPECT_EQ(stats.missing, 0);
  }
}

TEST(FillGaps, SlowPixelsAreNotFilled) {
  for (const Pace& pace : {Pace{0, 2.1, 0, 0}, Pace{0, 1.9, 0, .2}, Pace{0, 0, 0, 2.7}}) {
    const RenderStats stats = interrupted(pace);
    EXPECT_EQ(stats.filled, 0);
    EXPECT_EQ(stats.missing, 0.75);
  }
}

/// The measurement of omitted light takes 10 s, but isn't repeated to fill gaps.
TEST(FillGaps, LightLeftOutIsNotMeasuredAgain) {
  EXPECT_EQ(interrupted({10, 1.5, 0, 0}).missing, 0);
}

/// Filling ends after two seconds, even if the estimate was lower.
TEST(FillGaps, EndsInTime) {
  const RenderStats late = interrupted({0, 0, 2.1, 0});
  EXPECT_EQ(late.filled, 0);
  EXPECT_EQ(late.missing, 0.75);
  // The set-up takes 1.5 s and each tile 0.3 s, so that two tiles start in time.
  const RenderStats half = interrupted({0, 0, 1.5, 1.2});
  EXPECT_EQ(half.filled, 0.5);
  EXPECT_EQ(half.missing, 0.25);
}

}  // namespace
}  // namespace kinome::test::fill_gaps_test

// Time per stage of a render: stages are separated, and parts belong to their stage.
#include <gtest/gtest.h>

#include <atomic>

#include "render/paths/path_scenes.h"
#include "product_scenes.h"

namespace kinome::test::product_stages_test {
namespace {

constexpr const char* kPartsOfMain[] = {"primary",  "strata", "candidates", "comb",
                                        "eye rays", "shadow", "film"};

double seconds_of_parts(const RenderStats& stats) {
  double seconds = 0;
  for (const char* part : kPartsOfMain) {
    const auto found = stats.counters.stage_seconds.find(part);
    if (found != stats.counters.stage_seconds.end()) seconds += found->second;
  }
  return seconds;
}

/// Glossy, and lit by the sky and a lamp: the pilot uses all parts, too.
std::unique_ptr<Scene> scene_to_learn() {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .2)));
  s.light += point_xml("0,3,3", "1");
  s.max_depth = 3;
  return product_scene(s);
}

void render_by(RenderContext& context) {
  const auto scene = scene_to_learn();
  const Sensor& sensor = *scene->sensors().front();
  sensor.film().prepare(scene->integrator().layers());
  scene->integrator().render(*scene, sensor, context);
}

TEST(ProductStages, PilotIsNoPartOfTheMainPass) {
  std::atomic<bool> cancel{false};
  RenderContext context(
      {.threads = 1, .cancel = &cancel, .progress = [&](double) { cancel = true; }});
  render_by(context);
  const auto& seconds = context.job.stats().counters.stage_seconds;
  ASSERT_TRUE(context.job.cancelled());
  EXPECT_GT(seconds.at("pilot"), 0);
  EXPECT_FALSE(seconds.contains("main"));
  EXPECT_EQ(seconds_of_parts(context.job.stats()), 0);
}

TEST(ProductStages, PartsTakeNoMoreTimeThanTheirStage) {
  RenderContext context({.threads = 1});
  render_by(context);
  const auto& seconds = context.job.stats().counters.stage_seconds;
  for (const char* part : kPartsOfMain) EXPECT_GT(seconds.at(part), 0) << part;
  EXPECT_LE(seconds_of_parts(context.job.stats()), seconds.at("main") * (1 + 1e-9));
}

}  // namespace
}  // namespace kinome::test::product_stages_test

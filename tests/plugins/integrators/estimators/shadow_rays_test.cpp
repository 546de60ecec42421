// Tests queued shadow rays and the destinations of their results.
#include "clustered/product/rays/shadow_rays.h"

#include "stage_tile.h"

namespace kinome::test::shadow_rays_test {
namespace {

/// Points of a ball, whose opposite side may occlude them.
class ShadowRaysTest : public testing::Test {
 protected:
  ShadowRaysTest() : tile_(ball_xml(kGrey) + sky_xml()), rays_(times_) {
    times_.count_to(counters_);
    rays_.begin(tile_.scene(), counters_);
  }
  SurfaceInteraction point(size_t i) const {
    return tile_.primaries().interaction(i % tile_.primaries().size());
  }
  /// Returns a direction up into the sky, or down through the ball.
  Vec3 direction(size_t i) const { return i % 3 == 0 ? -point(i).n : point(i).n; }
  static bool is_visible(size_t i) { return i % 3 != 0; }

  const StageTile tile_;
  RenderCounters counters_;
  StageTimes times_;
  ShadowRays rays_;
};

TEST_F(ShadowRaysTest, AddVisibleLightToTheirSums) {
  constexpr size_t kRays = 5000;  // several batches
  Rgb sums[2] = {Rgb(0.f), Rgb(0.f)};
  Rgb expected[2] = {Rgb(0.f), Rgb(0.f)};
  for (size_t i = 0; i < kRays; ++i) {
    const Rgb weight(static_cast<float>(i % 7), 1, -2);
    rays_.push(point(i), direction(i), {weight, 0, 0}, {{&sums[i % 2]}});
    if (is_visible(i)) expected[i % 2] += weight;
  }
  rays_.trace();
  for (int k = 0; k < 2; ++k) EXPECT_EQ(sums[k], expected[k]);
  EXPECT_EQ(counters_[RayKind::kShadow], kRays);
  rays_.trace();
  EXPECT_EQ(sums[0], expected[0]) << "results are added once";
}

TEST_F(ShadowRaysTest, SkipRaysWithoutLight) {
  Rgb sum(1.f);
  for (size_t i = 0; i < 10; ++i) {
    rays_.push(point(i), direction(i), {Rgb(0.f), 0, 0}, {{&sum}});
    rays_.push(point(i), direction(i), 5, {Rgb(0.f), 0, 0}, {{&sum}}, {});
  }
  rays_.trace();
  EXPECT_EQ(sum, Rgb(1.f));
  EXPECT_EQ(counters_[RayKind::kShadow], 0u);
  EXPECT_EQ(counters_.skipped_shadow_rays, 20u);
}

TEST_F(ShadowRaysTest, AddRecordsToTheirPatches) {
  constexpr size_t kRays = 3000;
  std::vector<std::vector<VisibilityRecord>> records(3);
  const Answers answers{{}, records.data(), nullptr};
  Rgb sum(0.f);
  float lit = 0;
  for (size_t i = 0; i < kRays; ++i) {
    const auto cell = static_cast<uint32_t>(i % 500);
    const ShadowRays::Light light{Rgb(1.f), cell, static_cast<int32_t>(i % 2)};
    const ShadowRays::Lit of_lamp{i % 10 == 1 ? &lit : nullptr, 0.5f};
    rays_.push(point(i), direction(i), kInfinity, light, answers, of_lamp);
    // Rays of an estimate may be queued between them.
    if (i % 100 == 1) rays_.push(point(i), direction(i), {Rgb(2.f), 0, -1}, {{&sum}});
  }
  rays_.trace();
  ASSERT_EQ(records[0].size(), kRays / 2);
  ASSERT_EQ(records[1].size(), kRays / 2);
  EXPECT_TRUE(records[2].empty());
  float expected_lit = 0, expected_sum = 0;
  for (size_t i = 0; i < kRays; ++i) {
    const VisibilityRecord record = records[i % 2][i / 2];
    EXPECT_EQ(record.cell(), i % 500);
    EXPECT_EQ(record.visible(), is_visible(i)) << i;
    expected_lit += i % 10 == 1 && is_visible(i) ? 0.5f : 0.f;
    expected_sum += i % 100 == 1 && is_visible(i) ? 2.f : 0.f;
  }
  EXPECT_EQ(lit, expected_lit);
  EXPECT_EQ(sum, Rgb(expected_sum));
}

/// Rays sideways through two sheets, and down through the ball.
TEST(ShadowRaysThroughPanes, WeakenLight) {
  const StageTile tile(
      ball_xml(kGrey) + sky_xml() +
      R"(<shape type="rectangle"><transform name="to_world"><scale value=".4"/>
      <rotate y="1" angle="90"/><translate x="1.5" y="1.25"/></transform>
      <bsdf type="null"/></shape>
      <shape type="rectangle"><transform name="to_world"><scale value=".4"/>
      <rotate y="1" angle="90"/><translate x="2.5" y="1.75"/></transform>
      <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="diffuse"/></bsdf></shape>)");
  const transport::SceneTable table(tile.scene());
  RenderCounters counters;
  StageTimes times;
  times.count_to(counters);
  ShadowRays rays(times, &table, 5);
  rays.begin(tile.scene(), counters);
  const SurfaceInteraction top = tile.primaries().interaction(0);
  ASSERT_GT(top.n.y, 0.9f);
  const Vec3 up = glm::normalize(Vec3(1, 0.5f, 0));
  std::vector<std::vector<VisibilityRecord>> records(1);
  for (const uint32_t max_passes : {0u, 1u, 2u, ~0u}) {
    const float expected = max_passes < 2 ? 0 : 0.5f;
    Rgb sum(0.f);
    rays.push(top, up, {Rgb(1, 2, 3), 0, 0, 0, max_passes}, {{&sum}});
    // Ends between the sheets.
    Rgb near(0.f);
    rays.push(top, up, 2.2f, {Rgb(1, 2, 3), 0, 0, 0, max_passes}, {{&near}}, {});
    Rgb down(0.f);
    rays.push(top, {0, -1, 0}, {Rgb(1.f), 0, 0, 0, max_passes}, {{&down}});
    rays.push(top, up, {Rgb(1.f), 7, 0, 0, max_passes}, {{}, records.data(), nullptr});
    rays.trace();
    EXPECT_EQ(sum, expected * Rgb(1, 2, 3)) << max_passes;
    EXPECT_EQ(near, max_passes < 1 ? Rgb(0.f) : Rgb(1, 2, 3)) << max_passes;
    EXPECT_EQ(down, Rgb(0.f));
    EXPECT_NEAR(records[0].back().value(), expected, 0.002f);
    EXPECT_EQ(records[0].back().cell(), 7u);
  }
}

}  // namespace
}  // namespace kinome::test::shadow_rays_test

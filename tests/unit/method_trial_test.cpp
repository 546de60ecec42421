// Which of two ways to a picture takes less work, by noise of a known size.
#include "clustered/product/method_trial.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clustered/product/spread.h"

namespace kinome::test {
namespace {

/// A way whose pixels have this mean and standard deviation, at a cost of `rays` per render.
MethodTrial::Way noise(uint64_t seed, float deviation, double rays, RenderContext& context,
                       double cost_of_ray = 1, float mean = 1) {
  const auto render = [=, &context](uint64_t index, std::vector<Rgb>& picture) {
    for (size_t i = 0; i < picture.size(); ++i) {
      const bool is_high = random_float(hash_words(seed, index, i), 0) < 0.5f;
      picture[i] = Rgb(is_high ? mean + deviation : mean - deviation);
    }
    context.stats().counters[RayKind::kBsdf] += static_cast<uint64_t>(rays);
  };
  return {render, cost_of_ray, 1};
}

TEST(MethodTrial, ComparesErrorTimesRays) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 5);
  ASSERT_TRUE(trial.is_possible());
  size_t wanted = 0;
  for (int block = 0; block < grid.blocks_x() * grid.blocks_y(); ++block) {
    grid.for_each_tile(block, [&](const TileGrid::Tile& tile) { wanted += trial.is_wanted(tile); });
  }
  EXPECT_NEAR(static_cast<double>(wanted), grid.tiles() * trial.share(),
              5 * std::sqrt(grid.tiles() * trial.share()));
  // Half of all pixels differ between two renders: their number n has a relative deviation of
  // 1 / sqrt(n), and of the two ways' ratio five of these make sqrt(2) x 5 / sqrt(n). What a
  // pixel's own mean does to its weight is small beside that where noise is.
  const double tolerance =
      5 * std::sqrt(2.) / std::sqrt(0.5 * static_cast<double>(wanted) * kTileSide * kTileSide);
  const auto work = [&](float deviation, double rays, double cost_of_ray) {
    return trial.compare(noise(1, 0.02f, 1000, context),
                         noise(2, deviation, rays, context, cost_of_ray), context)
        .work;
  };
  EXPECT_NEAR(work(0.02f, 1000, 1), 1, tolerance);
  EXPECT_NEAR(work(0.04f, 1000, 1) / 4, 1, tolerance);
  EXPECT_NEAR(work(0.02f, 3000, 1) / 3, 1, tolerance);
  EXPECT_NEAR(work(0.02f, 1000, 0.25) * 4, 1, tolerance);
}

/// Light that a way misses in all of its renders counts as noise of that size.
TEST(MethodTrial, MissedLightIsAnError) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 5);
  const auto work = [&](float first, float second) {
    return trial.compare(noise(1, 0.02f, 1000, context, 1, first),
                         noise(2, 0.02f, 1000, context, 1, second), context)
        .work;
  };
  // Half of all pixels differ between two renders, by 0.04: 0.0008 on average, and 2 x 0.1² for
  // the light that is missed. Deviations by noise are below 10 % of these.
  EXPECT_NEAR(work(0.9f, 1) * (1 + 25), 1, 0.2);
  EXPECT_NEAR(work(1, 0.9f) / (1 + 25), 1, 0.2);
}

TEST(MethodTrial, ChoosesTheFirstWayWhereThereIsNothingToCompare) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 128, 128});
  const MethodTrial trial(grid, 5);
  // The first way misses next to nothing by chance.
  EXPECT_GT(trial.compare(noise(1, 0, 1000, context), noise(2, 0.1f, 1000, context), context).work,
            100);
  EXPECT_EQ(trial.compare(noise(1, 0.1f, 0, context), noise(2, 0.1f, 1000, context), context).work,
            kInfinity);
  EXPECT_FALSE(MethodTrial(TileGrid({0, 0, 24, 28}), 5).is_possible());
}

}  // namespace
}  // namespace kinome::test

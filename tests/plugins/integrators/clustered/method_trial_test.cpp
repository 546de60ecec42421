// Tests which of two rendering methods needs less work, with noise of known variance.
#include "clustered/product/trial/method_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "clustered/product/tiles/spread.h"

namespace kinome::test::method_trial_test {
namespace {

/// Returns a method whose pixels have this mean and standard deviation, at `rays` rays per render.
MethodTrial::Way noise(uint64_t seed, float deviation, double rays, RenderContext& context,
                       double cost_of_ray = 1, float mean = 1) {
  const auto render = [=, &context](const MethodTrial&, uint64_t index, std::span<Rgb> picture) {
    for (size_t i = 0; i < picture.size(); ++i) {
      const bool is_high = random_float(hash_words(seed, index, i), 0) < 0.5f;
      picture[i] = Rgb(is_high ? mean + deviation : mean - deviation);
    }
    context.job.stats().counters[RayKind::kBsdf] += static_cast<uint64_t>(rays);
  };
  return {render, cost_of_ray};
}

/// Returns the work of the second method for equal error, relative to the first one's; infinity if
/// nothing was measured.
double work_of(const MethodTrial::Result& result) {
  if (result.tiles.empty()) return kInfinity;
  double first = 0, second = 0;
  for (const MethodTrial::TileErrors& tile : result.tiles) {
    first += tile.first;
    second += tile.second;
  }
  return second * result.cost / first;
}

TEST(MethodTrial, TilesAreWholeAndSpreadOverTheImage) {
  for (const auto& [width, height, tiles] :
       {std::tuple(160, 120, 24), {1280, 720, 256}, {161, 122, 24}, {12, 9, 24}, {300, 5, 24}}) {
    const TileGrid grid({3, 7, 3 + width, 7 + height});
    const MethodTrial trial(grid, tiles, 9);
    const std::vector<size_t> pixels = trial.pixels();
    const auto count = static_cast<int>(pixels.size()) / (kTileSide * kTileSide);
    EXPECT_EQ(static_cast<int>(pixels.size()), count * kTileSide * kTileSide);
    EXPECT_EQ(trial.share(), static_cast<double>(count) / grid.tiles());
    EXPECT_GE(count, std::min(tiles, grid.tiles() / 2) - 3);
    EXPECT_LE(count, std::min(tiles, grid.tiles() / 2) + 3);
    EXPECT_EQ(std::set(pixels.begin(), pixels.end()).size(), pixels.size());
    // Both halves of the image have some pixels.
    int left = 0, top = 0;
    for (const size_t i : pixels) {
      left += static_cast<int>(i) % width < width / 2;
      top += static_cast<int>(i) / width < height / 2;
    }
    if (count < 8) continue;
    EXPECT_NEAR(left, static_cast<double>(pixels.size()) / 2, 0.3 * pixels.size());
    if (height > 8) {
      EXPECT_NEAR(top, static_cast<double>(pixels.size()) / 2, 0.3 * pixels.size());
    }
  }
  EXPECT_TRUE(MethodTrial(TileGrid({0, 0, 3, 100}), 24, 5).empty());
}

TEST(MethodTrial, KeepsAShareOfItsTiles) {
  const TileGrid grid({0, 0, 320, 320});
  MethodTrial trial(grid, 256, 5);
  const double before = trial.share();
  trial.keep(2);
  EXPECT_EQ(trial.share(), before);
  trial.keep(0.25);
  EXPECT_EQ(trial.share(), before / 4);
  const std::vector<size_t> pixels = trial.pixels();
  EXPECT_EQ(pixels.size(), 64u * kTileSide * kTileSide);
  const auto left =
      std::count_if(pixels.begin(), pixels.end(), [](size_t i) { return i % 320 < 160; });
  EXPECT_NEAR(static_cast<double>(left), pixels.size() / 2., 0.15 * pixels.size());
  for (const double share : {0., -1.}) {
    trial.keep(share);
    EXPECT_EQ(trial.pixels().size(), MethodTrial::kMinTiles * kTileSide * kTileSide);
  }
}

struct Tent final : ReconstructionFilter {
  Tent() { radius_ = 1; }
  float eval(float x) const override { return std::max(0.f, 1 - std::abs(x)); }
};

TEST(PixelFilter, HasTheWeightsOfWholePixels) {
  const PixelFilter box, tent{Tent()};
  for (int d = -PixelFilter::kReach; d <= PixelFilter::kReach; ++d) {
    EXPECT_EQ(box.weight(d, 0), d == 0 ? 1 : 0);
    // An eighth of the tent's area is outside a pixel on either side.
    EXPECT_NEAR(tent.weight(d, 0),
                sqr(0.75f) * (d == 0             ? 1
                              : std::abs(d) == 1 ? 1 / 6.f
                                                 : 0),
                1e-4f);
    EXPECT_NEAR(tent.weight(d, 1) * 6, tent.weight(d, 0), 1e-4f);
  }
  EXPECT_EQ(box.variance(), 1);
  EXPECT_NEAR(tent.variance(), sqr(sqr(0.75f) + 2 * sqr(0.125f)), 1e-4f);
}

/// The film's filter removes noise of single pixels, but not noise that whole tiles share.
TEST(MethodTrial, MeasuresFilteredNoise) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const PixelFilter tent{Tent()};
  const MethodTrial trial(grid, 256, 5, tent);
  const MethodTrial::Way tiles{
      [&](const MethodTrial&, uint64_t index, std::span<Rgb> picture) {
        for (size_t i = 0; i < picture.size(); ++i) {
          const size_t tile = i % 320 / kTileSide + i / 320 / kTileSide * grid.tiles_x();
          picture[i] = Rgb(random_float(hash_words(1, index, tile), 0) < 0.5f ? 1.02f : 0.98f);
        }
        context.job.stats().counters[RayKind::kBsdf] += 1000;
      },
      1};
  const double work = work_of(trial.compare(noise(2, 0.02f, 1000, context), tiles, context));
  // At the edges of tiles, the filter also removes some of their noise, and less of that of pixels.
  EXPECT_GT(work, 0.6 / tent.variance());
  EXPECT_LT(work, 1 / tent.variance());
}

TEST(MethodTrial, ComparesErrorTimesRays) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 256, 5);
  // Half of all pixels differ between two renders. This number n has a relative deviation of 1 /
  // sqrt(n), and the ratio of both methods one of sqrt(2) / sqrt(n). The tolerance is five of
  // these. The effect of a pixel's mean on its weight is smaller.
  const double tolerance =
      5 * std::sqrt(2.) / std::sqrt(0.5 * static_cast<double>(trial.pixels().size()));
  const auto work = [&](float deviation, double rays, double cost_of_ray) {
    return work_of(trial.compare(noise(1, 0.02f, 1000, context),
                                 noise(2, deviation, rays, context, cost_of_ray), context));
  };
  EXPECT_NEAR(work(0.02f, 1000, 1), 1, tolerance);
  EXPECT_NEAR(work(0.04f, 1000, 1) / 4, 1, tolerance);
  EXPECT_NEAR(work(0.02f, 3000, 1) / 3, 1, tolerance);
  EXPECT_NEAR(work(0.02f, 1000, 0.25) * 4, 1, tolerance);
}

/// The error of a single render by the first method is estimated from its difference to the renders
/// of the second.
TEST(MethodTrial, EndsAfterOneRenderThatIsEnough) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 256, 5);
  MethodTrial::Way first = noise(1, 0.1f, 1000, context);
  int renders = 0;
  first.render = [&, render = first.render](const MethodTrial& tiles, uint64_t index,
                                            std::span<Rgb> picture) {
    ++renders;
    render(tiles, index, picture);
  };
  const MethodTrial::Way second = noise(2, 0.05f, 500, context);
  double work = 0;
  const auto is_enough = [&](bool answer) {
    return [&, answer](const MethodTrial::Result& result) {
      work = work_of(result);
      return answer;
    };
  };
  const auto result = trial.compare(first, second, context, is_enough(true));
  EXPECT_EQ(renders, 1);
  EXPECT_EQ(work_of(result), work);
  EXPECT_LT(result.tiles.size(), 100u);  // of 256
  // Each render differs from the mean by its deviation in every pixel. Hence the only noise is the
  // product of both methods' deviations.
  EXPECT_NEAR(work * 8, 1, 0.1);
  EXPECT_EQ(trial.compare(first, second, context, is_enough(false)).tiles.size(), 256u);
  EXPECT_EQ(renders, 4);  // of the other tiles, and of all tiles
  first.more_variance.assign(320 * 320, 0.01f);
  work = 0;
  trial.compare(first, second, context, is_enough(true));
  EXPECT_EQ(renders, 6);
  EXPECT_EQ(work, 0);
}

/// Light that a method misses in all renders counts as noise of that magnitude.
TEST(MethodTrial, MissedLightIsAnError) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 256, 5);
  const auto work = [&](float first, float second) {
    return work_of(trial.compare(noise(1, 0.02f, 1000, context, 1, first),
                                 noise(2, 0.02f, 1000, context, 1, second), context));
  };
  // Half of all pixels differ between two renders by 0.04, which is 0.0008 on average; the missed
  // light is 2 x 0.1². The noise of these values is below 10 %.
  EXPECT_NEAR(work(0.9f, 1) * (1 + 25), 1, 0.2);
  EXPECT_NEAR(work(1, 0.9f) / (1 + 25), 1, 0.2);
}

TEST(MethodTrial, EstimatesTheUncertaintyOfBrightness) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 320, 320});
  const MethodTrial trial(grid, 256, 5);
  const auto deviation = [&](float of_render, float first, float noise_of_second,
                             double common_share = 1) {
    const auto render = [=, &context](const MethodTrial&, uint64_t index, std::span<Rgb> picture) {
      std::fill(picture.begin(), picture.end(), Rgb(first + (index == 0 ? 1 : -1) * of_render));
      context.job.stats().counters[RayKind::kBsdf] += 1000;
    };
    MethodTrial::Way way{render, 1};
    way.common_share = common_share;
    return trial.compare(way, noise(2, noise_of_second, 1000, context), context).deviation;
  };
  // The two renders of the first method differ by twice their deviation. The variance of one is
  // twice its square. The brightness is the mean over both methods.
  EXPECT_NEAR(deviation(0.1f, 1, 0), std::sqrt(2) * 0.1, 1e-5);
  EXPECT_NEAR(deviation(0.1f, 1, 0, 0.25), std::sqrt(2) * 0.05, 1e-5);
  EXPECT_NEAR(deviation(0, 0.9f, 0), 0.1 / 0.95, 1e-5);
  // The mean of the first method's two renders may differ from the truth by half of that variance.
  EXPECT_NEAR(deviation(0.1f, 0.9f, 0, 0), 0, 1e-5);
  EXPECT_NEAR(deviation(0.1f, 0.8f, 0, 0), std::sqrt(0.04 - 0.01) / 0.9, 1e-5);
  EXPECT_NEAR(deviation(0.1f, 1.2f, 0, 0), std::sqrt(0.04 - 0.01) / 1.1, 1e-5);
  // The second method's noise explains a difference. Its mean over 4,096 pixels and two renders has
  // a standard error of at most 0.5 / sqrt(2 * 4096); five of them are permitted.
  EXPECT_LT(deviation(0, 1, 0.5f), 5 * 0.5 / std::sqrt(2 * 4096.));
  EXPECT_EQ(deviation(0, 1, 0), 0);
}

TEST(MethodTrial, ChoosesTheFirstMethodIfThereIsNothingToCompare) {
  RenderContext context({.threads = 1});
  const TileGrid grid({0, 0, 128, 128});
  const MethodTrial trial(grid, 256, 5);
  // By chance, the first method seems to miss a little light, or to find a little too much.
  const double inverse = 1 / work_of(trial.compare(noise(1, 0, 1000, context),
                                                   noise(2, 0.1f, 1000, context), context));
  EXPECT_LT(std::abs(inverse), 0.01);
  EXPECT_TRUE(trial.compare(noise(1, 0.1f, 0, context), noise(2, 0.1f, 1000, context), context)
                  .tiles.empty());
}

}  // namespace
}  // namespace kinome::test::method_trial_test

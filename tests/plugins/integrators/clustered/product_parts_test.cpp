// Tests parts of product sampling: the comb, points along a Hilbert curve, samples of the film's
// filter, and the allocation of rays to pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "clustered/cells/hilbert_points.h"
#include "clustered/product/rays/comb.h"
#include "clustered/product/pilot/plan.h"
#include "kinome/sampler.h"
#include "support/render.h"

namespace kinome::test::product_parts_test {
namespace {

/// Strata with weights over six decades, some of them 0, in padded arrays.
struct Strata {
  std::vector<float> weights;
  std::vector<float> sums;
  double total = 0;

  explicit Strata(std::vector<float> values) : weights(std::move(values)) {
    weights.resize(padded(weights.size()));
    sums.resize(weights.size() / simd::kCellLanes);
    for (size_t i = 0; i < weights.size(); ++i) sums[i / simd::kCellLanes] += weights[i];
    for (const float s : sums) total += s;
  }
  std::vector<Comb::Hit> hits(size_t count, double offset) const {
    Comb comb(total, count, offset);
    std::vector<Comb::Hit> found;
    comb.pass(weights.data(), sums.data(), weights.size(), found);
    return found;
  }
};

Strata random_strata(size_t count, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<float> values(count);
  for (float& v : values) {
    const float u = static_cast<float>(rng() >> 8) * 0x1p-24f;
    v = rng() % 4 == 0 ? 0.f : std::pow(10.f, 6 * u - 3);
  }
  return Strata(std::move(values));
}

/// The combs of N offsets (k + 1/2) / N together are one comb with N times as many teeth. The
/// number of its teeth in a stratum differs from the stratum's share by at most one.
TEST(Comb, HitsAreProportionalToWeights) {
  constexpr int kOffsets = 2000;
  for (const size_t count : {1u, 7u, 64u}) {
    const Strata strata = random_strata(200, 3);
    std::vector<double> hits(strata.weights.size());
    for (int k = 0; k < kOffsets; ++k) {
      const auto found = strata.hits(count, (k + 0.5) / kOffsets);
      EXPECT_EQ(found.size(), count);
      for (const Comb::Hit& hit : found) ++hits.at(hit.stratum);
    }
    for (size_t i = 0; i < hits.size(); ++i) {
      const double expected =
          static_cast<double>(count) * strata.weights[i] / strata.total * kOffsets;
      // Rounding errors of the block sums add up along the line.
      EXPECT_NEAR(hits[i], expected, 1 + 1e-6 * static_cast<double>(count) * kOffsets) << i;
      EXPECT_TRUE(strata.weights[i] > 0 || hits[i] == 0) << i;
    }
  }
}

/// Remainders in one stratum over these combs are equally spaced. Their empirical distribution
/// differs from the uniform one by at most one step.
TEST(Comb, RemaindersAreUniform) {
  constexpr int kOffsets = 2000;
  const Strata strata({1, 0, 3, 0.5f, 8, 0, 0, 2});
  std::vector<std::vector<float>> remainders(strata.weights.size());
  for (int k = 0; k < kOffsets; ++k) {
    for (const Comb::Hit& hit : strata.hits(5, (k + 0.5) / kOffsets)) {
      EXPECT_GE(hit.remainder, 0.f);
      EXPECT_LT(hit.remainder, 1.f);
      remainders[hit.stratum].push_back(hit.remainder);
    }
  }
  for (std::vector<float>& r : remainders) {
    std::sort(r.begin(), r.end());
    for (size_t i = 0; i < r.size(); ++i) {
      const double n = static_cast<double>(r.size());
      EXPECT_NEAR(r[i], (static_cast<double>(i) + 0.5) / n, 1.01 / n);
    }
  }
}

/// A stratum whose weight is exactly the step has exactly one hit, for any other strata.
TEST(Comb, StrataAsLongAsTheStepAreHitOnce) {
  constexpr float kStep = 0.37f;
  std::mt19937 rng(4);
  std::vector<float> values(200);
  for (float& v : values) v = rng() % 3 == 0 ? kStep : 0.01f * static_cast<float>(rng() % 30);
  const Strata strata(values);
  for (int k = 0; k < 1000; ++k) {
    Comb comb = Comb::by_step(kStep, (k + 0.5) / 1000);
    std::vector<Comb::Hit> found;
    comb.pass(strata.weights.data(), strata.sums.data(), strata.weights.size(), found);
    EXPECT_NEAR(static_cast<double>(found.size()), strata.total / kStep, 1);
    std::vector<int> hits(values.size());
    for (const Comb::Hit& hit : found) ++hits.at(hit.stratum);
    for (size_t i = 0; i < values.size(); ++i) {
      EXPECT_TRUE(values[i] != kStep || hits[i] == 1) << i << " " << k;
    }
  }
}

TEST(Comb, IsOneLineThroughAllSegments) {
  const Strata a = random_strata(100, 5), b = random_strata(60, 6);
  for (const double offset : {0., 0.3, 0.999999}) {
    Comb comb(a.total + b.total, 40, offset);
    std::vector<Comb::Hit> hits;
    comb.pass(a.weights.data(), a.sums.data(), a.weights.size(), hits);
    const size_t first = hits.size();
    comb.pass(b.weights.data(), b.sums.data(), b.weights.size(), hits);
    EXPECT_EQ(hits.size(), 40u);
    EXPECT_NEAR(static_cast<double>(first), 40 * a.total / (a.total + b.total), 1);
    EXPECT_TRUE(std::is_sorted(hits.begin(), hits.begin() + static_cast<ptrdiff_t>(first),
                               [](const auto& x, const auto& y) { return x.stratum < y.stratum; }));
  }
}

/// The sums of blocks are rounded differently from their weights. Sums that are too large or too
/// small must not lose teeth, or hit strata of weight 0.
TEST(Comb, SumsThatRoundOtherwiseLoseNothing) {
  for (const float error : {-2e-7f, 2e-7f}) {
    Strata strata = random_strata(64, 9);
    strata.total = 0;
    for (float& s : strata.sums) strata.total += s *= 1 + error;
    for (int k = 0; k < 1000; ++k) {
      const auto found = strata.hits(300, (k + 0.5) / 1000);
      EXPECT_EQ(found.size(), 300u);
      for (const Comb::Hit& hit : found) EXPECT_GT(strata.weights[hit.stratum], 0);
    }
  }
}

/// The curve visits each of 2^5 x 2^5 cells once, and successive cells are adjacent.
TEST(HilbertPoints, CurveVisitsNeighbours) {
  constexpr uint32_t kSide = 32;
  std::vector<std::pair<int, int>> places(kSide * kSide, {-1, -1});
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t index = hilbert_index(x << 11, y << 11) >> 22;
      ASSERT_LT(index, places.size());
      EXPECT_EQ(places[index].first, -1);
      places[index] = {static_cast<int>(x), static_cast<int>(y)};
    }
  }
  for (size_t i = 1; i < places.size(); ++i) {
    EXPECT_EQ(std::abs(places[i].first - places[i - 1].first) +
                  std::abs(places[i].second - places[i - 1].second),
              1)
        << i;
  }
}

TEST(HilbertPoints, AreNetsInTheOrderOfTheCurve) {
  for (uint32_t log2 = 0; log2 <= HilbertPoints::kMaxLog2; ++log2) {
    const auto points = HilbertPoints::get().power_of_two(log2);
    ASSERT_EQ(points.size(), size_t{1} << log2);
    for (size_t i = 1; i < points.size(); ++i) {
      EXPECT_LE(hilbert_index(points[i - 1].x >> 16, points[i - 1].y >> 16),
                hilbert_index(points[i].x >> 16, points[i].y >> 16));
    }
    // One point is in each elementary interval of any shape, after any digital shift.
    for (uint32_t x_bits = 0; x_bits <= log2; ++x_bits) {
      std::set<std::pair<int, int>> intervals;
      for (size_t i = 0; i < points.size(); ++i) {
        const Vec2 u = points[i].shifted(0x9e3779b9u, 0x7f4a7c15u);
        EXPECT_GE(std::min(u.x, u.y), 0);
        EXPECT_LT(std::max(u.x, u.y), 1);
        intervals.emplace(static_cast<int>(std::ldexp(u.x, static_cast<int>(x_bits))),
                          static_cast<int>(std::ldexp(u.y, static_cast<int>(log2 - x_bits))));
      }
      EXPECT_EQ(intervals.size(), points.size()) << log2 << ", " << x_bits;
    }
  }
}

TEST(HilbertPoints, FirstOnesAreOfOneSequence) {
  std::set<std::pair<uint32_t, uint32_t>> before;
  for (uint32_t count = 1; count <= HilbertPoints::kMaxCount; ++count) {
    std::set<std::pair<uint32_t, uint32_t>> all;
    for (const IntegerPoint& p : HilbertPoints::get().first(count)) all.emplace(p.x, p.y);
    EXPECT_EQ(all.size(), count);
    EXPECT_TRUE(std::includes(all.begin(), all.end(), before.begin(), before.end()));
    before = std::move(all);
  }
}

struct Budget {
  double rays = 0;  ///< mean over pixels, of primaries and shadow rays
  uint16_t min_primaries = 65535;
  uint16_t max_primaries = 0;
  uint16_t max_rays = 0;
};
Budget total_of(std::span<const PixelPlan> plan) {
  Budget budget;
  for (const PixelPlan& p : plan) {
    budget.rays += p.primaries + p.rays;
    budget.min_primaries = std::min(budget.min_primaries, p.primaries);
    budget.max_primaries = std::max(budget.max_primaries, p.primaries);
    budget.max_rays = std::max(budget.max_rays, p.rays);
    EXPECT_GT(p.candidates, 0);
    EXPECT_LE(p.candidates, 4000);
  }
  budget.rays /= static_cast<double>(plan.size());
  return budget;
}

/// Returns the forecast of an image with a gradient, edges, gloss, and background at the top.
std::vector<PixelForecast> picture(int width, int height) {
  std::vector<PixelForecast> forecast(static_cast<size_t>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      PixelForecast& p = forecast[static_cast<size_t>(y) * width + x];
      const float u = to_unit_float(static_cast<uint32_t>(hash_words(x, y)));
      p.mean = 0.1f + 0.02f * static_cast<float>(x);
      if (y < height / 4) continue;
      p.deviation = u * std::sqrt(0.1f);
      p.uncertainty = 0.5f * u + (x % 16 == 0 ? 3.f : 0.f);
      p.glossy_deviation = y > height / 2 ? std::sqrt(2 * u) : 0.f;
      p.sharp = y > 3 * height / 4;
    }
  }
  return forecast;
}

using Mode = RayAllocation::Mode;

LargeArray<PixelPlan> plan_of(std::span<const PixelForecast> forecast, int width, int height,
                              Mode mode, double rays) {
  RenderContext context({.threads = 2});
  return RayAllocation(forecast, width, height, mode, context.scheduler)
      .plan(rays, context.scheduler);
}

TEST(Allocate, KeepsTheBudget) {
  for (const Mode mode : {Mode::kEven, Mode::kAdaptive, Mode::kSmoothed}) {
    for (const double rays : {3., 6., 12., 24., 48., 120., 500.}) {
      const Budget budget = total_of(plan_of(picture(64, 48), 64, 48, mode, rays));
      EXPECT_NEAR(budget.rays, rays, 0.03 * rays) << static_cast<int>(mode);
      EXPECT_GE(budget.min_primaries, 1);
      EXPECT_LE(budget.max_rays, 1024);
    }
  }
}

/// Threads divide an image of this size into parts. Rounding errors don't add up.
TEST(Allocate, KeepsTheBudgetOfALargerImage) {
  for (const double rays : {12., 48.}) {
    EXPECT_NEAR(total_of(plan_of(picture(200, 150), 200, 150, Mode::kSmoothed, rays)).rays, rays,
                0.01 * rays);
  }
}

/// Parts of an image, which consist of rows, read the rows of their neighbours: rows are like the
/// columns of the transposed image.
TEST(Allocate, PartsContinueOneAnother) {
  constexpr size_t kSide = 128;
  std::vector<PixelForecast> rows(kSide * kSide), columns(kSide * kSide);
  for (size_t i = 0; i < rows.size(); ++i) {
    PixelForecast& p = rows[i];
    p.mean = 1 + to_unit_float(static_cast<uint32_t>(hash_words(i / kSide, 1)));
    p.uncertainty = to_unit_float(static_cast<uint32_t>(hash_words(i / kSide)));
    p.glossy_deviation = p.uncertainty;
    p.sharp = i / kSide % 3 == 0;
    columns[i % kSide * kSide + i / kSide] = p;
  }
  const auto a = plan_of(rows, kSide, kSide, Mode::kSmoothed, 40);
  const auto b = plan_of(columns, kSide, kSide, Mode::kSmoothed, 40);
  for (size_t i = 0; i < a.size(); ++i) {
    const PixelPlan& mirrored = b[i % kSide * kSide + i / kSide];
    EXPECT_NEAR(a[i].primaries, mirrored.primaries, 1);
    EXPECT_NEAR(a[i].rays, mirrored.rays, 1);
    EXPECT_NEAR(a[i].candidates, mirrored.candidates, 1e-3 * mirrored.candidates);
  }
}

/// If all pixels are alike, they must not all be rounded in the same direction.
TEST(Allocate, KeepsTheBudgetOfAnEvenImage) {
  PixelForecast even;
  even.mean = 1;
  even.deviation = std::sqrt(0.02f);
  even.uncertainty = 0.3f;
  for (const Mode mode : {Mode::kEven, Mode::kAdaptive, Mode::kSmoothed}) {
    for (const double rays : {5., 7., 8., 11., 13., 24., 27., 48.}) {
      const std::vector<PixelForecast> forecast(256, even);
      EXPECT_NEAR(total_of(plan_of(forecast, 16, 16, mode, rays)).rays, rays, 0.03 * rays)
          << static_cast<int>(mode) << ", " << rays;
    }
  }
}

TEST(Allocate, SendsRaysToUncertainPixels) {
  const auto plan = plan_of(picture(64, 48), 64, 48, Mode::kAdaptive, 48);
  const auto at = [&](int x, int y) { return plan[static_cast<size_t>(y) * 64 + x]; };
  EXPECT_GT(at(16, 20).rays, at(8, 20).rays);           // uncertain visibility
  EXPECT_LT(at(20, 2).primaries + at(20, 2).rays, 12);  // background
  EXPECT_GT(at(10, 28).candidates, at(10, 15).candidates);
}

/// A pilot with one primary overestimates some pixels and underestimates others.
TEST(Allocate, SmoothingTakesOutTheForecastsNoise) {
  std::vector<PixelForecast> forecast(64 * 64);
  for (size_t i = 0; i < forecast.size(); ++i) {
    forecast[i].mean = 0.2f + to_unit_float(static_cast<uint32_t>(hash_words(i, 1)));
    forecast[i].deviation = 0.3f;
    forecast[i].uncertainty = 0.5f;
  }
  const auto spread = [&](Mode mode) {
    double sum = 0, squares = 0;
    for (const PixelPlan& p : plan_of(forecast, 64, 64, mode, 200)) {
      sum += p.rays;
      squares += static_cast<double>(p.rays) * p.rays;
    }
    const double n = 64 * 64;
    return std::sqrt(squares / n - sqr(sum / n)) / (sum / n);
  };
  EXPECT_GT(spread(Mode::kAdaptive), 0.3);
  EXPECT_LT(spread(Mode::kSmoothed), 0.5 * spread(Mode::kAdaptive));
}

TEST(Allocate, NotAdaptiveGivesAllTheSame) {
  std::vector<PixelForecast> forecast = picture(32, 32);
  for (PixelForecast& p : forecast) p.uncertainty += 0.1f;
  const auto plan = plan_of(forecast, 32, 32, Mode::kEven, 36);
  for (const PixelPlan& p : plan) {
    EXPECT_NEAR(p.primaries, plan[0].primaries, 1);
    EXPECT_NEAR(p.rays, plan[0].rays, 1);
  }
}

/// For any forecast, each pixel gets a primary and at most the rays that a pass supports.
TEST(Allocate, AcceptsAnyForecast) {
  PixelForecast dark;
  PixelForecast sky;
  sky.mean = 3;
  PixelForecast hidden;  // surfaces without expected light
  hidden.uncertainty = 1e-3f;
  PixelForecast tiny{1e-25f, 0, 1e-26f, 0, false};
  PixelForecast huge{1e25f, 1e26f, 1e24f, 1e26f, true};
  for (const PixelForecast& each : {dark, sky, hidden, tiny, huge}) {
    for (const double rays : {2., 12., 100.}) {
      const auto plan = plan_of(std::vector<PixelForecast>(64, each), 8, 8, Mode::kAdaptive, rays);
      const Budget budget = total_of(plan);
      EXPECT_GE(budget.min_primaries, 1);
      EXPECT_LE(budget.rays, std::max(3., 1.1 * rays)) << each.mean << ", " << each.uncertainty;
      // Uncertain light is not left to control terms.
      EXPECT_TRUE(each.uncertainty == 0 || plan.front().rays > 0) << each.mean;
    }
  }
}

}  // namespace
}  // namespace kinome::test::product_parts_test

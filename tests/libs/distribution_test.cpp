#include "kinome/distribution.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "support/statistics.h"

namespace kinome::distribution_test {
namespace {

struct Grid {
  uint32_t columns;
  uint32_t rows;
  std::vector<float> weights;
};

Grid random_grid(uint32_t columns, uint32_t rows, uint32_t seed) {
  Grid grid{columns, rows, {}};
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t i = 0; i < columns * rows; ++i) {
    const float u = uniform(rng);
    // A third of the weights is zero and a few are far larger than the rest, like an image of a
    // sun.
    grid.weights.push_back(u < 0.33f ? 0 : u > 0.99f ? 500 * u : u);
  }
  return grid;
}

void expect_frequencies(const Grid& grid) {
  const GridDistribution distribution(grid.columns, grid.rows, grid.weights);
  double sum = 0;
  for (const float w : grid.weights) sum += w;
  EXPECT_NEAR(distribution.total(), sum, 1e-12 * sum);
  constexpr int kSamples = 400000;
  std::vector<double> observed(grid.weights.size()), expected;
  for (const float w : grid.weights) expected.push_back(kSamples * (w / sum));
  std::vector<double> remainders(64);
  std::mt19937 rng(7);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 u(static_cast<float>(rng() >> 8) * 0x1p-24f,
                 static_cast<float>(rng() >> 8) * 0x1p-24f);
    const auto cell = distribution.sample(u);
    ASSERT_LT(cell.column, grid.columns);
    ASSERT_LT(cell.row, grid.rows);
    ASSERT_TRUE(cell.u.x >= 0 && cell.u.x < 1 && cell.u.y >= 0 && cell.u.y < 1);
    observed[cell.row * grid.columns + cell.column] += 1;
    remainders[static_cast<int>(cell.u.x * 8) * 8 + static_cast<int>(cell.u.y * 8)] += 1;
  }
  const auto cells = test::chi2_test(observed, expected, 1e-4);
  EXPECT_TRUE(cells.passed) << grid.columns << " x " << grid.rows << ": " << cells.text;
  const auto within = test::chi2_test(remainders, std::vector<double>(64, kSamples / 64.), 1e-4);
  EXPECT_TRUE(within.passed) << grid.columns << " x " << grid.rows << ": " << within.text;
}

TEST(GridDistribution, PicksCellsByTheirWeights) {
  uint32_t seed = 1;
  for (const auto& [columns, rows] :
       {std::pair{1u, 1u}, {1u, 7u}, {7u, 1u}, {2u, 2u}, {3u, 5u}, {64u, 32u}, {129u, 65u}}) {
    Grid grid = random_grid(columns, rows, seed++);
    grid.weights[grid.weights.size() / 2] = 3;  // at least one weight is positive
    expect_frequencies(grid);
  }
}

// Random numbers at the ends of [0, 1)² never select a cell of zero weight.
TEST(GridDistribution, NeverPicksACellOfNoWeight) {
  const float ends[] = {0.f, 0x1p-24f, 0.25f, 0.5f, 0.75f, kOneMinusEpsilon, 1.f};
  for (uint32_t at = 0; at < 35; ++at) {
    std::vector<float> weights(35);
    weights[at] = 1e-30f;
    const GridDistribution distribution(7, 5, weights);
    for (const float x : ends) {
      for (const float y : ends) {
        const auto cell = distribution.sample(Vec2(x, y));
        ASSERT_EQ(cell.row * 7 + cell.column, at);
        ASSERT_LT(cell.u.x, 1);
        ASSERT_LT(cell.u.y, 1);
      }
    }
  }
}

TEST(GridDistribution, IsMonotone) {
  const Grid grid = random_grid(50, 20, 11);
  const GridDistribution distribution(grid.columns, grid.rows, grid.weights);
  double before = -1;
  for (int i = 0; i < 10000; ++i) {
    const auto cell = distribution.sample(Vec2(0.3f, static_cast<float>(i) * 1e-4f));
    const double place = cell.row + static_cast<double>(cell.u.y);
    ASSERT_GE(place, before);
    before = place;
  }
}

TEST(GridDistribution, OfZeroWeightsHasATotalOfZero) {
  EXPECT_EQ(GridDistribution().total(), 0);
  EXPECT_EQ(GridDistribution(3, 2, std::vector<float>(6)).total(), 0);
  EXPECT_THROW(GridDistribution(3, 2, std::vector<float>(5)), std::invalid_argument);
  EXPECT_THROW(GridDistribution(0, 2, {}), std::invalid_argument);
}

}  // namespace
}  // namespace kinome::distribution_test

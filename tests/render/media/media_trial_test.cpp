// Tests how the trial of `clustered` in media compares both methods.
#include "clustered/media/media_trial.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "support/statistics.h"

namespace kinome::test::media_trial_test {
namespace {

using Blocks = std::vector<std::array<BlockWork, 2>>;

/// Returns blocks of errors that vary log-normally by `spread`, independently for both methods.
/// `volpath` has `error` times the error at `cost` times the cost.
Blocks random_blocks(std::mt19937& random, size_t count, double spread, double error, double cost) {
  std::normal_distribution<double> normal(0, spread);
  Blocks blocks(count);
  for (auto& [candidates, paths] : blocks) {
    candidates = {std::exp(normal(random)), 3};
    paths = {error * std::exp(normal(random)), 3 * cost};
  }
  return blocks;
}

TEST(MediaTrial, ComparesTotalErrorTimesTotalCost) {
  const Gain gain = gain_of_first(Blocks{{{{2, 10}, {12, 3}}}, {{{4, 20}, {24, 6}}}});
  EXPECT_DOUBLE_EQ(gain.log, std::log(6 * 0.3));  // 36 x 9 to 6 x 30
  EXPECT_NEAR(gain.error, 0, 1e-12);
  const Gain of_sums = gain_of_first(Blocks{{{{1, 1}, {0, 1}}}, {{{1, 1}, {6, 5}}}});
  EXPECT_DOUBLE_EQ(of_sums.log, std::log(6. / 2 * 6 / 2));
}

/// With two blocks, the jackknife's error is half of the distance of the values without either.
TEST(MediaTrial, HasTheErrorOfTheJackknife) {
  const Gain gain = gain_of_first(Blocks{{{{1, 1}, {1, 1}}}, {{{1, 1}, {5, 1}}}});
  EXPECT_DOUBLE_EQ(gain.log, std::log(3.));
  EXPECT_NEAR(gain.error, std::log(5.) / 2, 1e-12);
  const Gain of_three =
      gain_of_first(Blocks{{{{1, 1}, {1, 1}}}, {{{1, 1}, {1, 1}}}, {{{1, 1}, {4, 1}}}});
  const double a = std::log(5. / 2), b = std::log(2. / 2), mean = (2 * a + b) / 3;
  EXPECT_NEAR(of_three.error,
              std::sqrt((2 * (a - mean) * (a - mean) + (b - mean) * (b - mean)) * 2 / 3), 1e-12);
}

TEST(MediaTrial, SurvivesBlocksWithoutErrorOrCost) {
  const std::array<BlockWork, 2> black{}, even{{{1, 1}, {1, 1}}};
  for (const Blocks& blocks : {Blocks{black, black}, Blocks{even, black}}) {
    const Gain gain = gain_of_first(blocks);
    EXPECT_EQ(gain.log, 0);
    EXPECT_TRUE(std::isfinite(gain.error));
    EXPECT_FALSE(is_clear(gain));
  }
  EXPECT_TRUE(is_clear(gain_of_first(Blocks(3, {{{0, 1}, {1, 1}}}))));
  EXPECT_FALSE(is_clear(gain_of_first(Blocks(3, {{{1, 1}, {0, 1}}}))));
}

/// The estimated gain differs from the true one by about its standard error. The sum of n squared
/// ratios is compared with n; it has a standard deviation of about sqrt(2 n), and more for few
/// blocks, whose errors are uncertain. The bounds have a false-alarm rate below 1e-4.
TEST(MediaTrial, KnowsTheErrorOfItsGain) {
  std::mt19937 random(5);
  constexpr int kTrials = 400;
  double squares = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Gain gain = gain_of_first(random_blocks(random, 24, 0.5, 2, 0.7));
    squares += std::pow((gain.log - std::log(1.4)) / gain.error, 2);
  }
  EXPECT_NEAR(squares / kTrials, 1.1, 4 * std::sqrt(2.2 / kTrials));
}

/// Candidates that take as much work as `volpath` are seldom preferred, also by few blocks with
/// very different errors, and those that take a third nearly always by many.
TEST(MediaTrial, PrefersCandidatesOnlyForAClearGain) {
  std::mt19937 random(7);
  constexpr int kTrials = 400;
  const auto share = [&](size_t blocks, double spread, double gain) {
    int preferred = 0;
    for (int i = 0; i < kTrials; ++i) {
      preferred += is_clear(gain_of_first(random_blocks(random, blocks, spread, gain, 1)));
    }
    return static_cast<double>(preferred) / kTrials;
  };
  EXPECT_LT(share(24, 0.5, 1), 0.15);
  EXPECT_LT(share(3, 0.5, 1), 0.25);
  EXPECT_LT(share(3, 2, 1), 0.25);
  EXPECT_GT(share(24, 0.5, 3), 0.99);
  EXPECT_GT(share(3, 0.2, 3), 0.99);
  EXPECT_EQ(share(24, 0.5, 0.5), 0);
}

/// A single block with a rare bright path doesn't decide.
TEST(MediaTrial, OneBlockDoesNotDecide) {
  Blocks blocks(12, {{{1, 2}, {1, 1}}});
  EXPECT_FALSE(is_clear(gain_of_first(blocks)));
  blocks[5][1].error = 30;  // all in all, `volpath` seems to take 1.7 times the work
  const Gain gain = gain_of_first(blocks);
  EXPECT_GT(gain.log, std::log(1.5));
  EXPECT_FALSE(is_clear(gain));
}

}  // namespace
}  // namespace kinome::test::media_trial_test

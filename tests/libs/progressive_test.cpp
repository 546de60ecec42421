// Tests budgets of time and error with simulated passes, whose speed, noise and clock are known.
#include "session/progressive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "kinome/log.h"
#include "support/render.h"

namespace kinome::test::progressive_test {
namespace {

struct Speed {
  double sample = 1e-3;  ///< in seconds
  double pass = 0;       ///< overhead of each pass in seconds
  double unsteady = 0;   ///< relative standard deviation of the time
  double forecast = 0;   ///< seconds_per_sample() divided by the true value
};

/// Renders grey pixels, each darker than the previous one, with proportional noise.
class FakePasses final : public Passes {
 public:
  FakePasses(Film& film, double deviation, Speed speed = {}, uint64_t seed = 1)
      : film_(film), deviation_(deviation), speed_(speed), random_(seed) {}

  double samples() const override { return 64; }
  double seconds_per_sample() const override { return speed_.forecast * speed_.sample; }
  double render(double samples) override {
    sizes.push_back(samples);
    std::normal_distribution<double> normal;
    double seconds = speed_.pass + samples * speed_.sample;
    if (speed_.unsteady > 0) seconds *= std::max(0.1, 1 + speed_.unsteady * normal(random_));
    constexpr int kBlocks = 20;
    int done = 0;
    context->scheduler.for_each(kBlocks, [&](size_t, RenderCounters&) {
      now += seconds / kBlocks;
      ++done;
    });
    if (done < kBlocks) return samples;
    FilmTile tile = film_.make_tile(film_.crop());
    for (int y = 0; y < film_.height(); ++y) {
      for (int x = 0; x < film_.width(); ++x) {
        const double noise = deviation_ * normal(random_) / std::sqrt(samples);
        const auto value = static_cast<float>(truth(x, y) * (1 + noise));
        tile.add_pixel(x, y, std::vector<float>(3, value), static_cast<float>(samples));
      }
    }
    film_.commit(tile);
    return samples;
  }
  static double truth(int x, int y) { return 1. / (1 + x + 3 * y); }

  std::vector<double> sizes;
  double now = 0;
  RenderContext* context = nullptr;

 private:
  Film& film_;
  double deviation_;
  Speed speed_;
  std::mt19937_64 random_;
};

std::shared_ptr<Film> film_of(int width, int height) {
  return make<Film>("<film type=\"hdrfilm\"><integer name=\"width\" value=\"" +
                    std::to_string(width) + "\"/><integer name=\"height\" value=\"" +
                    std::to_string(height) + "\"/><rfilter type=\"box\"/></film>");
}

/// A render with simulated passes.
struct MadeUp {
  std::shared_ptr<Film> film;
  FakePasses passes;
  std::vector<double> progress;  ///< values of the progress callback
  std::vector<double> seen;      ///< samples of the images that the pass callback received
  RenderContext context;
  /// `showing`: time in seconds that the pass callback takes; negative: no callback.
  MadeUp(int side, const RenderBudget& budget, double deviation, Speed speed = {},
         uint64_t seed = 1, double start = 0, const std::atomic<bool>* cancel = nullptr,
         double showing = -1)
      : film(film_of(side, side)),
        passes(*film, deviation, speed, seed),
        context({.threads = 1,
                 .cancel = cancel,
                 .progress = [this](double share) { progress.push_back(share); },
                 .budget = budget,
                 .clock = [this] { return passes.now; }}) {
    passes.now = start;
    film->prepare({{}}, lanes_for(budget, *film));
    passes.context = &context;
    PassCallback on_pass;
    if (showing >= 0) {
      on_pass = [this, showing](const Image& picture, const RenderStats& stats) {
        EXPECT_GT(picture.at(0, 0, 0), 0);
        seen.push_back(stats.samples);
        passes.now += showing;
      };
    }
    render_passes(passes, *film, context.job, on_pass);
  }
  double samples() const { return std::accumulate(passes.sizes.begin(), passes.sizes.end(), 0.); }
  double rel_mse() const {
    const Image image = film->develop();
    double mean = 0, sum = 0;
    const double pixels = static_cast<double>(image.width) * image.height;
    for (int i = 0; i < image.width * image.height; ++i) {
      mean += FakePasses::truth(i % image.width, i / image.width) / pixels;
    }
    for (int i = 0; i < image.width * image.height; ++i) {
      const double r = FakePasses::truth(i % image.width, i / image.width);
      const double d = image.at(i % image.width, i / image.width, 0) - r;
      sum += d * d / (r * r + 0.01 * mean * mean);
    }
    return sum / pixels;
  }
};

TEST(Time, IsKeptAndUsed) {
  for (const double seconds : {0.5, 1., 10., 3600.}) {
    for (const double sample : {1e-5, 1e-3, 0.015}) {
      for (const double overhead : {0., 5 * sample}) {
        for (const double forecast : {0., 0.5, 1., 3.}) {
          const Speed speed{sample, overhead, 0.02, forecast};
          MadeUp run(4, {.seconds = seconds}, 0.1, speed, 7, 0.1);
          const double slack = std::max(0.05 * seconds, 0.05);
          EXPECT_LE(run.passes.now, seconds + slack) << sample << " " << overhead;
          // The remaining time may be too short for another pass.
          EXPECT_GE(run.passes.now, seconds - slack - sample - overhead)
              << sample << " " << forecast;
          EXPECT_LE(run.passes.sizes.size(), 30u);
          EXPECT_TRUE(std::is_sorted(run.progress.begin(), run.progress.end()));
        }
      }
    }
  }
}

TEST(Time, AWildGuessIsCutShort) {
  // A pass takes twice or half the time that the previous one predicted.
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    MadeUp run(4, {.seconds = 2}, 0.1, {1e-4, 1e-3, 0.5, 1}, seed, 0.2);
    EXPECT_LE(run.passes.now, 2.2) << seed;  // the current block is finished
  }
}

TEST(Time, IncludesWritingTheFile) {
  RenderBudget budget{.seconds = 2};
  budget.seconds_after = [](const Image& picture) {
    EXPECT_EQ(picture.width, 4);
    return 0.7;
  };
  MadeUp run(4, budget, 0.1);
  EXPECT_LE(run.passes.now, 1.35);
  EXPECT_GE(run.passes.now, 1.2);
}

TEST(Time, AlwaysGivesAnImage) {
  MadeUp run(4, {.seconds = 0.001}, 0.1, {0.05}, 1, 0.3);
  EXPECT_EQ(run.passes.sizes, std::vector<double>{1});
  EXPECT_NEAR(run.film->develop().at(0, 0, 0), 1, 0.5);
  EXPECT_EQ(run.context.job.stats().samples, 1);
}

/// The ratio of the estimate to the truth. With at least 2048 squares, the estimate has a standard
/// deviation below 4 %; the true error of one image of 256 values has 9 %. A factor of 1.5 is more
/// than 4 deviations, so that each test fails falsely at a rate below 1e-4.
TEST(Error, IsEstimatedWithinAFactor) {
  for (const double target : {0.03, 1e-3, 4e-5}) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      MadeUp run(16, {.rel_mse = target}, 0.5, {}, seed);
      const double estimate = run.context.job.stats().rel_mse;
      EXPECT_LE(estimate, target);
      EXPECT_GT(estimate, 0);
      EXPECT_LT(estimate, 1.5 * run.rel_mse()) << target << " " << seed;
      EXPECT_GT(estimate, run.rel_mse() / 1.5) << target << " " << seed;
      // The number of samples is necessary, except for one round: 0.22 is the mean of r²/(r² +
      // floor) x 0.5² or less.
      EXPECT_LE(run.samples(), std::max(16., 2 * 0.25 / target)) << target << " " << seed;
    }
  }
}

/// The error is at most a factor of 1.5 below the target. A quarter more samples than needed, and
/// the estimate's deviation (2 % of 24576 squares), are less than half of that. The minimum number
/// of samples for an estimate may have a smaller error, which is logged.
TEST(Error, EndsWhenItIsReached) {
  set_log_level(LogLevel::kInfo);
  for (const double target : {0.2, 0.05, 0.04, 0.03, 0.02, 0.01, 3e-3, 1e-4}) {
    for (uint64_t seed = 1; seed <= 3; ++seed) {
      testing::internal::CaptureStderr();
      MadeUp run(64, {.rel_mse = target}, 0.5, {}, seed);
      const std::string messages = testing::internal::GetCapturedStderr();
      const double estimate = run.context.job.stats().rel_mse;
      EXPECT_LE(estimate, target) << seed;
      EXPECT_TRUE(std::is_sorted(run.progress.begin(), run.progress.end()));
      EXPECT_LE(run.progress.back(), 1);
      const bool is_minimum = run.samples() == 4;
      if (!is_minimum) {
        EXPECT_GT(estimate, target / 1.5) << target << " " << seed;
      }
      EXPECT_EQ(is_minimum, target > 0.1) << run.samples();
      EXPECT_EQ(messages.find("needs that many samples") != std::string::npos,
                estimate < target / 1.5)
          << target << messages;
    }
  }
  set_log_level(LogLevel::kWarn);
}

/// Lanes with different numbers of samples: the estimate is still that of the mean. With 24576
/// squares, and 4096 for the truth, a factor of 1.1 is more than 4 deviations.
TEST(Error, IsEstimatedOfLanesOfDifferentLength) {
  const auto film = film_of(64, 64);
  film->prepare({{}}, 4);
  RenderContext context({.threads = 1});
  FakePasses passes(*film, 0.1);
  passes.context = &context;
  const std::vector<double> samples = {3, 1, 1, 2};
  double sum = 0;
  for (uint32_t lane = 0; lane < 4; ++lane) {
    film->set_lane(lane);
    sum += passes.render(samples[lane]);
  }
  const Image image = film->develop();
  double mean = 0, rel_mse = 0;
  for (int i = 0; i < 64 * 64; ++i) mean += FakePasses::truth(i % 64, i / 64) / (64 * 64);
  for (int i = 0; i < 64 * 64; ++i) {
    const double r = FakePasses::truth(i % 64, i / 64), d = image.at(i % 64, i / 64, 0) - r;
    rel_mse += d * d / (r * r + 0.01 * mean * mean) / (64 * 64);
  }
  const double estimate = estimate_rel_mse(*film, samples).value();
  EXPECT_LT(estimate, 1.1 * rel_mse) << sum;
  EXPECT_GT(estimate, rel_mse / 1.1);
}

TEST(Error, RoundsGrowAndEndAtTheLimit) {
  MadeUp run(8, {.rel_mse = 1e-30}, 0.5);
  EXPECT_NEAR(run.samples(), RenderBudget::kMaxSamples, 1);
  EXPECT_NEAR(run.context.job.stats().samples, run.samples(), 1e-9);
  const uint32_t lanes = run.film->lanes();
  EXPECT_EQ(run.passes.sizes.size() % lanes, 0u);
  for (size_t i = lanes; i + lanes < run.passes.sizes.size(); ++i) {
    EXPECT_GE(run.passes.sizes[i], run.passes.sizes[i - lanes]);
  }
}

TEST(Error, NoNoiseEndsAtOnce) {
  MadeUp run(8, {.rel_mse = 1e-30}, 0);
  EXPECT_LE(run.samples(), 16);
  EXPECT_EQ(run.context.job.stats().rel_mse, 0);
}

TEST(Error, TimeEndsItToo) {
  MadeUp run(8, {.seconds = 1, .rel_mse = 1e-30}, 0.5, {1e-3, 0, 0.01, 0});
  EXPECT_LE(run.passes.now, 1.05);
  EXPECT_GE(run.passes.now, 0.9);
  MadeUp other(8, {.seconds = 100, .rel_mse = 0.01}, 0.5, {1e-3, 0, 0.01, 0});
  EXPECT_LE(other.passes.now, 1);
}

/// A small film has more lanes; they must not make the film large.
TEST(Lanes, AsManyAsAnEstimateNeeds) {
  EXPECT_EQ(lanes_for({}, *film_of(10, 10)), 1u);
  EXPECT_EQ(lanes_for({.seconds = 3}, *film_of(10, 10)), 1u);
  EXPECT_EQ(lanes_for({.rel_mse = 3}, *film_of(1, 1)), 16u);
  EXPECT_EQ(lanes_for({.rel_mse = 3}, *film_of(512, 512)), 4u);
  EXPECT_EQ(lanes_for({.rel_mse = 3, .lanes = 9}, *film_of(512, 512)), 9u);
}

TEST(Lanes, DivideTheScenesSamples) {
  MadeUp run(16, {.lanes = 8}, 0.5);
  EXPECT_EQ(run.passes.sizes, std::vector<double>(8, 8));
  const Image image = develop(*run.film, run.context.job.budget(), run.context.job.stats());
  ASSERT_EQ(image.channels,
            (std::vector<std::string>{"R", "G", "B", "variance.R", "variance.G", "variance.B",
                                      "tile_variance.R", "tile_variance.G", "tile_variance.B"}));
  EXPECT_EQ(run.context.job.stats().renders, 8u);
  EXPECT_EQ(run.context.job.stats().variance_of_mean.size(), 3u);
  // The ratio to the true variance, 0.5² r² / 64, is the mean of 256 chi² of 7 degrees of freedom.
  // The tolerance is 5 standard deviations.
  double sum = 0;
  for (int i = 0; i < 256; ++i) {
    const double r = FakePasses::truth(i % 16, i / 16);
    sum += image.at(i % 16, i / 16, 4) / (0.25 * r * r / 64);
  }
  EXPECT_NEAR(sum / 256, 1, 5 * std::sqrt(2. / (7 * 256)));
}

/// The callback receives each pass, and the image has the same bits as without a callback.
TEST(Callback, ChangesNothing) {
  for (const RenderBudget& budget : {RenderBudget{.rel_mse = 1e-3}, RenderBudget{.lanes = 8}}) {
    MadeUp plain(8, budget, 0.5);
    MadeUp seen(8, budget, 0.5, {}, 1, 0, nullptr, 0);
    EXPECT_EQ(seen.passes.sizes, plain.passes.sizes);
    EXPECT_EQ(seen.film->develop().data, plain.film->develop().data);
    ASSERT_EQ(seen.seen.size(), seen.passes.sizes.size());
    double sum = 0;
    for (size_t i = 0; i < seen.seen.size(); ++i) {
      sum += seen.passes.sizes[i];
      EXPECT_EQ(seen.seen[i], sum);
    }
    EXPECT_EQ(seen.context.job.stats().samples, sum);
  }
}

/// The time of the callback counts toward the budget, but not as time of samples.
TEST(Callback, ItsTimeIsPartOfTheBudget) {
  for (const double showing : {0., 0.01, 0.2}) {
    for (const double forecast : {0., 1.}) {
      MadeUp run(4, {.seconds = 2}, 0.1, {1e-3, 0, 0.02, forecast}, 1, 0, nullptr, showing);
      EXPECT_LE(run.passes.now, 2.1) << showing << " " << forecast;
      EXPECT_GE(run.passes.now, 1.9 - showing) << showing << " " << forecast;
      const double shown = showing * static_cast<double>(run.seen.size());
      EXPECT_GE(run.samples() * 1e-3, 0.9 * (1.9 - shown - showing)) << showing << " " << forecast;
      EXPECT_FALSE(run.seen.empty());
      EXPECT_LE(run.seen.size(), 6u) << showing << " " << forecast;
    }
  }
  // The image with the minimum number of samples is shown even if the time is over.
  MadeUp late(4, {.seconds = 0.001}, 0.1, {0.05}, 1, 0.3, nullptr, 0);
  EXPECT_EQ(late.seen, std::vector<double>{1});
}

TEST(Interrupted, BeginsNothingMore) {
  std::atomic<bool> cancel{true};
  MadeUp run(8, {.rel_mse = 1e-9}, 0.1, {}, 1, 0, &cancel);
  EXPECT_EQ(run.passes.sizes.size(), 1u);
}

}  // namespace
}  // namespace kinome::test::progressive_test

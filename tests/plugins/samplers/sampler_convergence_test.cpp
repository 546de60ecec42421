/// Tests how fast the errors of each sampler decrease.
#include <gtest/gtest.h>

#include <cmath>

#include "sampler_helpers.h"
#include "support/statistics.h"

namespace kinome::test::sampler_convergence_test {
namespace {

/// A smooth function whose integral over the square is 0.
double smooth(const Vec2& v) {
  return std::exp(v.x) * std::cos(2 * v.y) - (std::exp(1.0) - 1) * std::sin(2.0) / 2;
}

/// Returns the squared errors of the mean of n samples, over pixels.
Moments squared_errors(const Sampler& sampler, uint32_t n, uint32_t pixels) {
  Moments squares;
  for (uint32_t p = 0; p < pixels; ++p) {
    double sum = 0;
    for (uint32_t i = 0; i < n; ++i) sum += smooth(sampler.value_2d({p, p / 7, i, 11}, 4));
    squares.add(sum / n * sum / n);
  }
  return squares;
}

TEST(Convergence, ErrorsFallAsEachMethodPromises) {
  // Slopes of the variance from 16 to 1024 samples: -1 in general. For smooth integrands they are
  // -2 for stratified samples (jittered in two dimensions), and -3 with a log factor for scrambled
  // nets (Owen 1997). With 1500 randomisations a variance is known to about 4 %, and a slope over 6
  // octaves to .013.
  const struct {
    const char* type;
    double low;
    double high;
  } cases[] = {{"independent", -1.1, -0.9},
               {"stratified", -2.1, -1.9},
               {"halton", -3.5, -1.6},
               {"sobol", -3.1, -2.6},
               {"multijitter", -3.1, -1.9}};
  for (const auto& c : cases) {
    const auto few = make_sampler(c.type, 16);
    const auto many = make_sampler(c.type, 1024);
    const double slope = std::log2(squared_errors(*many, 1024, 1500).mean() /
                                   squared_errors(*few, 16, 1500).mean()) /
                         6;
    EXPECT_GT(slope, c.low) << c.type;
    EXPECT_LT(slope, c.high) << c.type;
  }
}

/// Owen's nested uniform scramble by its definition: a hash of all higher bits flips each bit.
uint32_t nested_scramble(uint32_t v, uint64_t key) {
  uint32_t flips = 0;
  for (int bit = 31; bit >= 0; --bit) {
    const uint64_t above = bit == 31 ? 0 : v >> (bit + 1);
    flips |= static_cast<uint32_t>(hash_words(key, above, static_cast<uint64_t>(bit)) & 1) << bit;
  }
  return v ^ flips;
}

/// The hashed scramble has the variance of Owen's scramble for the same net.
TEST(Sobol, HashedScrambleHasTheVarianceOfOwens) {
  constexpr uint32_t kRuns = 6000;
  const auto sampler = make_sampler("sobol", 64);
  for (const uint32_t n : {16u, 64u, 256u}) {
    Moments owen;
    for (uint32_t run = 0; run < kRuns; ++run) {
      double sum = 0;
      for (uint32_t i = 0; i < n; ++i) {
        // Sobol's first two dimensions, bit by bit from their definition.
        uint32_t x = 0;
        uint32_t y = 0;
        uint32_t direction = 1u << 31;
        for (uint32_t k = 0; k < 32; ++k, direction ^= direction >> 1) {
          if (i >> k & 1) {
            x ^= 1u << (31 - k);
            y ^= direction;
          }
        }
        sum += smooth({to_unit_float(nested_scramble(x, hash_words(run, 1))),
                       to_unit_float(nested_scramble(y, hash_words(run, 2)))});
      }
      owen.add(sum / n * sum / n);
    }
    const Moments hashed = squared_errors(*sampler, n, kRuns);
    const double deviation = std::sqrt(owen.variance_of_mean() + hashed.variance_of_mean());
    // Tolerance: 5 standard deviations, and 3 % for the imperfect hash.
    EXPECT_NEAR(hashed.mean(), owen.mean(), 5 * deviation + 0.03 * owen.mean()) << n;
  }
}

}  // namespace
}  // namespace kinome::test::sampler_convergence_test

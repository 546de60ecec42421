/// Tests the guarantees of samplers that stratify sets of samples.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "sampler_helpers.h"

namespace kinome::test::sampler_strata_test {
namespace {

/// A permutation of few strata has few possible values, but each sample must still be uniform.
TEST(Stratified, FewStrataAreUniform) {
  for (const int count : {4, 9}) {
    const auto sampler = make_sampler("stratified", count);
    for (const uint32_t sample : {0u, 1u, 3u, 6u}) {
      const auto pair = [&](uint32_t i) { return sampler->value_2d({i, 5, sample, 0}, 0); };
      const Verdict verdict = uniform_pairs(pair, 100000);
      EXPECT_TRUE(verdict.passed) << count << ", sample " << sample << ": " << verdict.text;
    }
  }
}

TEST(Stratified, EveryBlockFillsEveryStratum) {
  const auto sampler = make_sampler("stratified", 49);
  ASSERT_EQ(sampler->sample_count(), 49u);
  std::set<std::pair<int, int>> first_cells;
  for (uint32_t pixel = 0; pixel < 200; ++pixel) {
    for (const uint32_t block : {0u, 1u, 9u}) {
      std::set<std::pair<int, int>> cells;
      std::set<int> intervals;
      for (uint32_t i = 0; i < 49; ++i) {
        const SampleKey key{pixel, 0, block * 49 + i, 0};
        const Vec2 v = sampler->value_2d(key, 0);
        cells.insert({static_cast<int>(v.x * 7), static_cast<int>(v.y * 7)});
        intervals.insert(static_cast<int>(sampler->value_1d(key, 4) * 49));
        if (i == 0) first_cells.insert(*cells.begin());
      }
      EXPECT_EQ(cells.size(), 49u);
      EXPECT_EQ(intervals.size(), 49u);
    }
  }
  EXPECT_EQ(first_cells.size(), 49u) << "the order of the strata differs between pixels";
}

/// Returns the number of distinct strata that contain samples.
size_t filled(const std::vector<uint32_t>& strata) {
  return std::set<uint32_t>(strata.begin(), strata.end()).size();
}

TEST(Strata, MultiJitterFillsSquaresAndLines) {
  for (const int wanted : {4, 6, 20, 64, 132}) {
    const auto sampler = make_sampler("multijitter", wanted);
    const uint32_t count = sampler->sample_count();
    uint32_t rows = 1;
    while ((rows + 1) * (rows + 1) <= static_cast<uint32_t>(wanted)) ++rows;
    const uint32_t columns = count / rows;
    for (const uint32_t first : {0u, 3 * count}) {
      std::vector<uint32_t> squares, x, y, lines;
      for (uint32_t i = 0; i < count; ++i) {
        const SampleKey key{7, 9, first + i, 1};
        const Vec2 v = sampler->value_2d(key, 4);
        const auto of = [](float u, uint32_t n) {
          return static_cast<uint32_t>(u * static_cast<float>(n));
        };
        squares.push_back(of(v.x, columns) * rows + of(v.y, rows));
        x.push_back(of(v.x, count));
        y.push_back(of(v.y, count));
        lines.push_back(of(sampler->value_1d(key, 4), count));
      }
      for (const auto& strata : {squares, x, y, lines}) EXPECT_EQ(filled(strata), count) << wanted;
    }
  }
}

TEST(Strata, OrthogonalFillsTheSquaresOfAnyTwoDimensions) {
  for (const uint32_t p : {2u, 3u, 7u, 11u}) {
    const auto sampler = make_sampler("orthogonal", static_cast<int>(p * p));
    for (uint32_t a = 0; a <= p; ++a) {
      for (uint32_t b = 0; b <= p; ++b) {
        std::vector<uint32_t> squares, lines;
        for (uint32_t i = 0; i < p * p; ++i) {
          const SampleKey key{7, 9, i + 2 * p * p, 1};
          const auto of = [&](uint32_t dimension, uint32_t n) {
            return static_cast<uint32_t>(sampler->value_1d(key, dimension) * static_cast<float>(n));
          };
          squares.push_back(of(a, p) * p + of(b, p));
          lines.push_back(of(a, p * p));
        }
        EXPECT_EQ(filled(squares), a == b ? p : p * p) << p << ": " << a << ", " << b;
        EXPECT_EQ(filled(lines), p * p);
      }
    }
  }
}

/// Sets that are too large for permutation tables.
TEST(Strata, OfLargeSetsAreFilled) {
  for (const char* const type : {"stratified", "multijitter", "orthogonal"}) {
    const auto sampler = make_sampler(type, 4900);
    const uint32_t count = sampler->sample_count();
    const auto side = static_cast<uint32_t>(std::sqrt(static_cast<float>(count)));
    ASSERT_EQ(side * side, count);
    std::vector<uint32_t> squares, lines;
    for (uint32_t i = 0; i < count; ++i) {
      const SampleKey key{7, 9, i + 2 * count, 1};
      const Vec2 v = sampler->value_2d(key, 4);
      const auto of = [](float u, uint32_t n) {
        return static_cast<uint32_t>(u * static_cast<float>(n));
      };
      squares.push_back(of(v.x, side) * side + of(v.y, side));
      lines.push_back(of(sampler->value_1d(key, 6), count));
    }
    EXPECT_EQ(filled(squares), count) << type;
    // Rounding may move a sample into the next stratum, which leaves its own one empty.
    EXPECT_GE(filled(lines), count - 3) << type;
  }
}

/// The samples of a set are in random order: any two of them are in any two strata.
TEST(Strata, OrdersOfSetsAreRandom) {
  for (const auto& [type, count] : {std::pair("stratified", 4),
                                    {"stratified", 9},
                                    {"multijitter", 6},
                                    {"multijitter", 9},
                                    {"orthogonal", 9}}) {
    const auto sampler = make_sampler(type, count);
    const auto n = static_cast<size_t>(count);
    for (const auto& [a, b] : {std::pair(0u, 1u), {0u, 2u}, {1u, 3u}}) {
      std::vector<double> observed(n * n), expected(n * n);
      constexpr uint32_t kPixels = 20000;
      for (uint32_t p = 0; p < kPixels; ++p) {
        const auto stratum = [&](uint32_t sample) {
          return static_cast<size_t>(sampler->value_1d({p, 2, sample, 0}, 3) *
                                     static_cast<float>(n));
        };
        ++observed[stratum(a) * n + stratum(b)];
      }
      for (size_t k = 0; k < n * n; ++k) {
        expected[k] = k / n == k % n ? 0 : kPixels / static_cast<double>(n * (n - 1));
      }
      // There are some thousand orders, not all: the tolerance is a tenth.
      for (size_t k = 0; k < n * n; ++k) {
        EXPECT_NEAR(observed[k], expected[k], 5 * std::sqrt(expected[k]) + 0.1 * expected[k])
            << type << " " << count << ": " << a << ", " << b << ", " << k;
      }
    }
  }
}

/// All samples are at the centres of their strata.
TEST(Strata, HonoursJitterFalse) {
  for (const char* const type : {"multijitter", "orthogonal", "stratified"}) {
    const auto sampler = make<Sampler>("<sampler type=\"" + std::string(type) +
                                       "\"><integer name=\"sample_count\" value=\"121\"/>"
                                       "<boolean name=\"jitter\" value=\"false\"/></sampler>");
    for (uint32_t i = 0; i < 300; ++i) {
      const float place = sampler->value_1d({1, 2, i, 3}, 5) * 121;
      EXPECT_NEAR(place - std::floor(place), 0.5f, 1e-4f) << type;
    }
  }
}

}  // namespace
}  // namespace kinome::test::sampler_strata_test

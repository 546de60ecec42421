#include "kinome/sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <set>

#include "sampler_helpers.h"

namespace kinome::test::sampler_test {
namespace {

class EverySampler : public testing::TestWithParam<const char*> {
 protected:
  std::shared_ptr<Sampler> sampler_ = make_sampler(GetParam(), 64);
};
INSTANTIATE_TEST_SUITE_P(Sampler, EverySampler,
                         testing::Values("independent", "stratified", "halton", "sobol",
                                         "multijitter", "orthogonal"));

TEST_P(EverySampler, ValuesLieInTheUnitIntervalForAnyKey) {
  const std::array<uint32_t, 8> words = {0, 1, 63, 64, 4095, 0x7fffffffu, 0x80000000u, ~0u};
  for (const uint32_t x : words) {
    for (const uint32_t sample : words) {
      for (const uint32_t dimension : {0u, 1u, 2u, 7u, 126u, 127u, 128u, 5000u, ~0u - 1}) {
        for (const uint64_t seed : {uint64_t{0}, ~uint64_t{0}}) {
          const SampleKey key{x, ~x, sample, seed};
          const float u = sampler_->value_1d(key, dimension);
          const Vec2 v = sampler_->value_2d(key, dimension);
          ASSERT_TRUE(u >= 0 && u < 1 && v.x >= 0 && v.x < 1 && v.y >= 0 && v.y < 1)
              << u << " " << v.x << " " << v.y;
        }
      }
    }
  }
}

TEST_P(EverySampler, IsAFunctionOfItsKey) {
  const auto other = make_sampler(GetParam(), 64);
  for (uint32_t i = 200; i-- > 0;) {
    const SampleKey key{i % 7, i % 11, i, i % 3};
    EXPECT_EQ(sampler_->value_1d(key, i % 5), other->value_1d(key, i % 5));
    EXPECT_EQ(sampler_->value_2d(key, i % 5), other->value_2d(key, i % 5));
  }
}

/// Takes one value of each pixel: they are independent and uniform, even if values within a pixel
/// are stratified. Pairs must be uniform in the square: two dimensions, neighbours, samples, seeds.
TEST_P(EverySampler, PixelsDimensionsAndSeedsAreIndependent) {
  constexpr uint32_t kCount = 100000;
  const Sampler& s = *sampler_;
  const auto key = [](uint32_t i, uint32_t sample = 5, uint64_t seed = 3) {
    return SampleKey{i % 400, i / 400, sample, seed};
  };
  const auto next = [&](uint32_t i) {
    SampleKey k = key(i);
    ++k.x;
    return k;
  };
  const auto below = [&](uint32_t i) {
    SampleKey k = key(i);
    ++k.y;
    return k;
  };
  const std::pair<const char*, std::function<Vec2(uint32_t)>> cases[] = {
      {"2d", [&](uint32_t i) { return s.value_2d(key(i), 2); }},
      {"2d, sample past the count", [&](uint32_t i) { return s.value_2d(key(i, 777), 2); }},
      {"dimensions 0, 1",
       [&](uint32_t i) { return Vec2(s.value_1d(key(i), 0), s.value_1d(key(i), 1)); }},
      {"dimensions 4, 90",
       [&](uint32_t i) { return Vec2(s.value_1d(key(i), 4), s.value_1d(key(i), 90)); }},
      {"pairs 0, 2 in x",
       [&](uint32_t i) { return Vec2(s.value_2d(key(i), 0).x, s.value_2d(key(i), 2).x); }},
      {"pairs 0, 2 in x, y",
       [&](uint32_t i) { return Vec2(s.value_2d(key(i), 0).x, s.value_2d(key(i), 2).y); }},
      {"1d and 2d",
       [&](uint32_t i) { return Vec2(s.value_1d(key(i), 0), s.value_2d(key(i), 1).x); }},
      {"neighbour in x",
       [&](uint32_t i) { return Vec2(s.value_2d(key(i), 0).x, s.value_2d(next(i), 0).x); }},
      {"neighbour in y, 1d",
       [&](uint32_t i) { return Vec2(s.value_1d(key(i), 0), s.value_1d(below(i), 0)); }},
      {"neighbouring seed",
       [&](uint32_t i) { return Vec2(s.value_2d(key(i), 0).y, s.value_2d(key(i, 5, 4), 0).y); }},
  };
  for (const auto& [name, pair] : cases) {
    const Verdict verdict = uniform_pairs(pair, kCount);
    EXPECT_TRUE(verdict.passed) << name << ": " << verdict.text;
  }
}

/// Each single value is uniform over all samples of many pixels, too.
TEST_P(EverySampler, SamplesOfAPixelAreUniform) {
  const Sampler& s = *sampler_;
  const auto key = [](uint32_t i) { return SampleKey{i / 64, 9, i % 64, 0}; };
  // Stratified samples vary less than independent ones: the test is conservative for them.
  EXPECT_TRUE(uniform_pairs([&](uint32_t i) { return s.value_2d(key(i), 6); }, 200000).passed);
  EXPECT_TRUE(
      uniform_pairs([&](uint32_t i) { return Vec2(s.value_1d(key(i), 6), s.value_1d(key(i), 7)); },
                    200000)
          .passed);
}

/// Within a pixel, the correlation r of two dimensions over n samples has mean 0 and mean square 1
/// / (n - 1), as for independent permutations. Sobol's mean square is up to twice that, because its
/// orders keep samples 2k and 2k + 1 together. Dimensions that share one order have a mean square
/// near 1. Halton's dimensions are correlated by design.
TEST_P(EverySampler, DimensionsOfAPixelAreNotCorrelated) {
  if (std::string(GetParam()) == "halton") return;
  constexpr uint32_t kSamples = 64;
  constexpr uint32_t kPixels = 4000;
  const std::pair<const char*, std::function<Vec2(const SampleKey&)>> cases[] = {
      {"1d",
       [&](const SampleKey& k) {
         return Vec2(sampler_->value_1d(k, 3), sampler_->value_1d(k, 4));
       }},
      {"2d",
       [&](const SampleKey& k) {
         return Vec2(sampler_->value_2d(k, 0).x, sampler_->value_2d(k, 2).x);
       }},
      {"2d, x and y", [&](const SampleKey& k) {
         return Vec2(sampler_->value_2d(k, 0).y, sampler_->value_2d(k, 2).x);
       }}};
  for (const auto& [name, pair] : cases) {
    Moments r;
    Moments r2;
    for (uint32_t p = 0; p < kPixels; ++p) {
      double xy = 0;
      double xx = 0;
      double yy = 0;
      Vec2 mean(0.f);
      std::array<Vec2, kSamples> values;
      for (uint32_t i = 0; i < kSamples; ++i) mean += values[i] = pair({p, 1, i, 2});
      mean /= static_cast<float>(kSamples);
      for (const Vec2& v : values) {
        xy += double{v.x - mean.x} * (v.y - mean.y);
        xx += double{v.x - mean.x} * (v.x - mean.x);
        yy += double{v.y - mean.y} * (v.y - mean.y);
      }
      const double c = xy / std::sqrt(xx * yy);
      r.add(c);
      r2.add(c * c);
    }
    // 5 standard deviations: 6e-7.
    EXPECT_LT(std::abs(r.mean()), 5 * std::sqrt(r.variance_of_mean())) << name;
    const double margin = 5 * std::sqrt(r2.variance_of_mean());
    const double max_r2 = (std::string(GetParam()) == "sobol" ? 2.0 : 1.0) / (kSamples - 1);
    // Any two dimensions of an orthogonal array are stratified together and less correlated.
    const bool is_array = std::string(GetParam()) == "orthogonal";
    if (!is_array) {
      EXPECT_GT(r2.mean(), 1.0 / (kSamples - 1) - margin) << name;
    }
    EXPECT_LT(r2.mean(), max_r2 + margin) << name;
  }
}

TEST_P(EverySampler, AnotherCountIsTheSameMethod) {
  const auto other = sampler_->with_sample_count(100);
  EXPECT_GE(other->sample_count(), 100u);
  EXPECT_LE(other->sample_count(), 128u);
  EXPECT_EQ(other->seed(), sampler_->seed());
  for (uint32_t i = 0; i < 300; ++i) {
    const Vec2 v = other->value_2d({1, 2, i, 0}, 0);
    EXPECT_TRUE(v.x >= 0 && v.x < 1 && v.y >= 0 && v.y < 1);
  }
}

/// Every elementary interval 2^-a x 2^-b, a + b = m, contains exactly one of the 2^m points.
void expect_net(const std::vector<Vec2>& points, int m, const std::string& what) {
  ASSERT_EQ(points.size(), size_t{1} << m);
  for (int a = 0; a <= m; ++a) {
    std::set<std::pair<uint32_t, uint32_t>> cells;
    for (const Vec2& p : points) {
      cells.insert({static_cast<uint32_t>(std::ldexp(p.x, a)),
                    static_cast<uint32_t>(std::ldexp(p.y, m - a))});
    }
    EXPECT_EQ(cells.size(), points.size()) << what << ", m " << m << ", a " << a;
  }
}

TEST(Sobol, EveryPairIsANetForEveryPowerOfTwo) {
  const auto sampler = make_sampler("sobol", 4);
  for (const uint32_t dimension : {0u, 1u, 2u, 17u, 1000u}) {
    for (uint32_t pixel = 0; pixel < 4; ++pixel) {
      for (int m = 0; m <= 10; ++m) {
        // The prefix, and aligned blocks that follow it.
        for (const uint32_t block : {0u, 1u, 5u}) {
          std::vector<Vec2> pairs;
          std::vector<Vec2> singles;
          for (uint32_t i = 0; i < 1u << m; ++i) {
            const SampleKey key{pixel, 3, (block << m) + i, pixel};
            pairs.push_back(sampler->value_2d(key, dimension));
            singles.push_back({sampler->value_1d(key, dimension), 0});
          }
          expect_net(pairs, m, "pair " + std::to_string(dimension));
          std::set<uint32_t> strata;
          for (const Vec2& p : singles) strata.insert(static_cast<uint32_t>(std::ldexp(p.x, m)));
          EXPECT_EQ(strata.size(), singles.size());
        }
      }
    }
  }
}

TEST(Halton, PowersOfTheBaseFillEveryInterval) {
  const auto sampler = make_sampler("halton", 4);
  const struct {
    uint32_t dimension;
    uint32_t base;
    uint32_t count;
  } cases[] = {{0, 2, 1024}, {1, 3, 729}, {2, 5, 625}, {3, 7, 343}, {10, 31, 961}};
  for (const auto& c : cases) {
    for (uint32_t pixel = 0; pixel < 8; ++pixel) {
      std::vector<double> values;
      for (uint32_t i = 0; i < c.count; ++i) {
        values.push_back(sampler->value_1d({pixel, 1, i, 0}, c.dimension));
      }
      std::sort(values.begin(), values.end());
      // Each interval contains one value. The ends of intervals are rounded as floats.
      for (uint32_t i = 0; i < c.count; ++i) {
        EXPECT_GE(values[i], static_cast<double>(i) / c.count - 0x1p-24) << "base " << c.base;
        EXPECT_LE(values[i], (i + 1.0) / c.count + 0x1p-24) << "base " << c.base;
      }
    }
  }
  // Bases 2 and 3 together: 4 x 9 boxes, 36 points.
  std::set<std::pair<int, int>> boxes;
  for (uint32_t i = 0; i < 36; ++i) {
    const Vec2 v = sampler->value_2d({3, 4, i, 0}, 0);
    boxes.insert({static_cast<int>(v.x * 4), static_cast<int>(v.y * 9)});
  }
  EXPECT_EQ(boxes.size(), 36u);
}

/// Returns a digit of a sample's value, counted from the highest; nullopt if it depends on digits
/// that a float doesn't store.
std::optional<uint32_t> halton_digit(const Sampler& sampler, uint32_t pixel, uint32_t sample,
                                     uint32_t dimension, uint32_t base, uint32_t digit) {
  const double value = sampler.value_1d({pixel, 3, sample, 0}, dimension);
  const double scale = std::pow(base, digit + 1);
  const double low = std::floor(value * scale);
  if (low != std::floor((value + 0x1p-24) * scale)) return std::nullopt;
  return static_cast<uint32_t>(std::fmod(low, base));
}

/// Owen's scramble: samples that share all lower digits get the same permutation of this digit, in
/// which all pairs of distinct results are equally likely. Other digits are permuted independently.
TEST(Halton, DigitsArePermutedAtRandom) {
  const auto sampler = make_sampler("halton", 64);
  const struct {
    uint32_t dimension, base;
    uint32_t a, b;
    uint32_t digit;  ///< the first digit that differs
  } cases[] = {{2, 5, 0, 5, 1},   {2, 5, 0, 1, 0},   {2, 5, 7, 12, 1},  {2, 5, 3, 1253, 4},
               {2, 5, 0, 375, 3}, {1, 3, 1, 2, 0},   {1, 3, 5, 8, 1},   {1, 3, 0, 81, 4},
               {9, 29, 0, 28, 0}, {9, 29, 1, 30, 1}, {9, 29, 58, 29, 1}};
  for (const auto& c : cases) {
    for (const uint32_t digit : {c.digit, c.digit + 1}) {
      const size_t base = c.base;
      std::vector<double> observed(base * base), expected(base * base);
      for (uint32_t pixel = 0; pixel < 30000; ++pixel) {
        const auto a = halton_digit(*sampler, pixel, c.a, c.dimension, c.base, digit);
        const auto b = halton_digit(*sampler, pixel, c.b, c.dimension, c.base, digit);
        if (a && b) ++observed[*a * base + *b];
      }
      const double total = std::accumulate(observed.begin(), observed.end(), 0.0);
      for (size_t k = 0; k < base * base; ++k) {
        const bool is_equal = k / base == k % base;
        if (digit > c.digit) {
          expected[k] = total / static_cast<double>(base * base);
        } else if (!is_equal) {
          expected[k] = total / static_cast<double>(base * (base - 1));
        } else {
          EXPECT_EQ(observed[k], 0) << c.base << ": " << c.a << ", " << c.b;
        }
      }
      const Verdict verdict = chi2_test(observed, expected, kFalseAlarm);
      EXPECT_TRUE(verdict.passed) << "base " << c.base << ": " << c.a << ", " << c.b << ", digit "
                                  << digit << ": " << verdict.text;
    }
  }
}

TEST(Sampler, CountsAreRoundedAsMitsubas) {
  const auto count = [](const char* type, int n) { return make_sampler(type, n)->sample_count(); };
  // Mitsuba 3.9.1: mi.load_dict({"type": type, "sample_count": n}).sample_count().
  EXPECT_EQ(count("independent", 17), 17u);
  EXPECT_EQ(count("stratified", 1), 1u);
  EXPECT_EQ(count("stratified", 2), 4u);
  EXPECT_EQ(count("stratified", 17), 25u);
  EXPECT_EQ(count("stratified", 100), 100u);
  EXPECT_EQ(count("stratified", 128), 144u);
  EXPECT_EQ(count("sobol", 1), 4u);
  EXPECT_EQ(count("sobol", 5), 16u);
  EXPECT_EQ(count("ldsampler", 17), 64u);
  EXPECT_EQ(count("ldsampler", 256), 256u);
  EXPECT_EQ(count("halton", 17), 17u);
  for (const auto& [wanted, got] : {std::pair(1, 1u),
                                    {2, 2u},
                                    {5, 6u},
                                    {7, 8u},
                                    {10, 12u},
                                    {17, 20u},
                                    {26, 30u},
                                    {50, 56u},
                                    {100, 100u},
                                    {122, 132u}}) {
    EXPECT_EQ(count("multijitter", wanted), got);
  }
  for (const auto& [wanted, got] : {std::pair(1, 4u),
                                    {4, 4u},
                                    {5, 9u},
                                    {10, 25u},
                                    {26, 49u},
                                    {50, 121u},
                                    {121, 121u},
                                    {122, 169u}}) {
    EXPECT_EQ(count("orthogonal", wanted), got);
  }
  EXPECT_EQ(make<Sampler>("<sampler type=\"independent\"/>")->sample_count(), 4u);
}

TEST(Sampler, RefusesImpossibleCounts) {
  for (const char* type :
       {"independent", "stratified", "halton", "sobol", "multijitter", "orthogonal"}) {
    EXPECT_THROW(make_sampler(type, 0), Error);
    EXPECT_THROW(make_sampler(type, -4), Error);
    EXPECT_THROW(make_sampler(type, 2000000000), Error);
  }
}

}  // namespace
}  // namespace kinome::test::sampler_test

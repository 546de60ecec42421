// Draws of weighted sources, with fewer SIMD lanes than a block has values (see CMakeLists.txt).
#include "clustered/media/sources/weighted_sources.h"

#include <gtest/gtest.h>

#include <map>

namespace kinome::test::weighted_sources_test {
namespace {

constexpr size_t kCapacity = 96;

/// Adds sources first ... first + count - 1, whose weights are their indices.
void add_indices(WeightedSources& sources, size_t first, size_t count) {
  sources.add(first, count, [&](size_t i) {
    float weights[kBlockLanes];
    for (size_t lane = 0; lane < wide::kLanes; ++lane) {
      weights[lane] = i + lane < first + count ? static_cast<float>(i + lane) : 0.f;
    }
    return wide::Float::load(weights);
  });
}

/// Expects draws at evenly spaced positions to choose each source in proportion to its weight.
void expect_draws(const WeightedSources& sources, const std::map<size_t, float>& weights) {
  constexpr int kDraws = 1 << 14;
  double total = 0;
  for (const auto& [source, weight] : weights) total += weight;
  EXPECT_FLOAT_EQ(sources.total(), static_cast<float>(total));
  std::map<size_t, int> draws;
  for (int i = 0; i < kDraws; ++i) {
    ++draws[sources.at((static_cast<float>(i) + 0.5f) / kDraws * sources.total())];
  }
  EXPECT_EQ(draws.size(), weights.size());
  for (const auto& [source, weight] : weights) {
    EXPECT_NEAR(draws[source], kDraws * weight / total, 2) << source;
    EXPECT_EQ(sources[source], weight) << source;
  }
}

TEST(WeightedSources, AreDrawnInProportionToTheirWeights) {
  transport::Arena arena(kCapacity);
  WeightedSources sources(arena);
  add_indices(sources, 0, 21);
  std::map<size_t, float> expected;
  for (size_t i = 1; i < 21; ++i) expected[i] = static_cast<float>(i);
  expect_draws(sources, expected);
}

/// A block has more values than a vector on most machines.
TEST(WeightedSources, EarlierWeightsAreNotDrawn) {
  transport::Arena arena(kCapacity);
  WeightedSources sources(arena);
  add_indices(sources, 0, kCapacity);
  for (const size_t count : {1, 5, 9, 13}) {
    sources.clear();
    add_indices(sources, 16, count);
    add_indices(sources, 64, 3);
    std::map<size_t, float> expected{{64, 64.f}, {65, 65.f}, {66, 66.f}};
    for (size_t i = 16; i < 16 + count; ++i) expected[i] = static_cast<float>(i);
    expect_draws(sources, expected);
  }
}

}  // namespace
}  // namespace kinome::test::weighted_sources_test

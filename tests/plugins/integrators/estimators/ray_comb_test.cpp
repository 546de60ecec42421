// Tests the line of strata, and the comb that assigns rays to them.
#include "clustered/product/rays/ray_comb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "plugins/integrators/kernels/kernel_helpers.h"

namespace kinome::test::ray_comb_test {
namespace {

using Kind = Strata::Kind;

void append(Kind kind, uint32_t group, const std::vector<float>& weights, Strata& strata) {
  const Strata::Columns columns =
      strata.append(kind, group, padded(weights.size()), 100 * group);
  for (size_t i = 0; i < padded(weights.size()); ++i) {
    columns.weights[i] = i < weights.size() ? weights[i] : 0.f;
    if (i % simd::kCellLanes == 0) columns.block_sums[i / simd::kCellLanes] = 0;
    columns.block_sums[i / simd::kCellLanes] += columns.weights[i];
  }
}

/// Returns weights over some decades, some of them 0.
std::vector<float> random_weights(size_t count, unsigned seed) {
  Random random(seed);
  std::vector<float> weights(count);
  for (float& w : weights) w = random.unit() < 0.2f ? 0 : std::pow(10.f, 3 * random.unit() - 2);
  return weights;
}

/// Returns the cells of one group, then candidates of two kinds.
Strata three_segments() {
  Strata strata;
  append(Kind::kDiffuse, 0, random_weights(70, 1), strata);
  append(Kind::kGlossy, 0, random_weights(48, 2), strata);
  append(Kind::kLocal, 1, random_weights(33, 3), strata);
  return strata;
}

TEST(Strata, LieOnOneLine) {
  Strata strata = three_segments();
  ASSERT_EQ(strata.segments().size(), 3u);
  size_t next = 0;
  double total = 0;
  for (const Strata::Segment& segment : strata.segments()) {
    EXPECT_EQ(segment.begin, next);
    EXPECT_EQ(segment.size % simd::kCellLanes, 0u);
    EXPECT_EQ(segment.first, 100 * segment.group);
    next += segment.size;
    for (size_t i = 0; i < segment.size; ++i) total += strata.columns(segment).weights[i];
  }
  EXPECT_EQ(strata.segments()[2].kind, Kind::kLocal);
  EXPECT_NEAR(strata.total(), total, 1e-6 * total);
  strata.clear();
  EXPECT_EQ(strata.segments().size(), 0u);
  EXPECT_EQ(strata.total(), 0);
}

/// The combs of N offsets together are one comb with N times as many teeth. The number of its teeth
/// in a stratum differs from the stratum's capped share by at most one.
TEST(RayComb, HitsAreProportionalToWeights) {
  constexpr int kOffsets = 1000;
  constexpr size_t kRays = 40;
  std::vector<double> hits(70 + 48 + 33 + 64), expected(hits.size());
  RayComb comb;
  double all = 0;
  for (int k = 0; k < kOffsets; ++k) {
    Strata strata = three_segments();
    size_t before = 0;
    comb.walk(strata, kRays, (k + 0.5) / kOffsets, [&](const SegmentHits& found) {
      EXPECT_EQ(found.before, before);
      before += found.hits.size();
      for (const Comb::Hit& hit : found.hits) {
        ++hits.at(found.segment.begin + hit.stratum);
        EXPECT_GT(found.weights[hit.stratum], 0);
      }
      for (size_t i = 0; i < found.segment.size; ++i) {
        const double rays = double{found.weights[i]} / found.step;
        expected.at(found.segment.begin + i) = rays * kOffsets;
        EXPECT_TRUE(found.segment.kind == Kind::kDiffuse || rays <= 1 + 1e-6) << i;
      }
    });
    all += static_cast<double>(before);
  }
  for (size_t i = 0; i < hits.size(); ++i) {
    EXPECT_NEAR(hits[i], expected[i], 1 + 1e-4 * kOffsets) << i;
  }
  EXPECT_NEAR(all / kOffsets, kRays, 1);
}

/// A candidate heavier than one ray has exactly one ray, for any other strata. Cells may have more.
TEST(RayComb, HeavyCandidatesHaveOneRay) {
  RayComb comb;
  for (int k = 0; k < 200; ++k) {
    Strata strata;
    append(Kind::kDiffuse, 0, std::vector<float>(20, 0.5f), strata);
    append(Kind::kGlossy, 0, {50, 0.1f, 0.1f, 1000}, strata);
    std::vector<int> of_candidate(16);
    size_t of_cells = 0;
    comb.walk(strata, 12, (k + 0.5) / 200, [&](const SegmentHits& found) {
      for (const Comb::Hit& hit : found.hits) {
        if (found.segment.kind == Kind::kDiffuse) ++of_cells;
        if (found.segment.kind == Kind::kGlossy) ++of_candidate.at(hit.stratum);
      }
    });
    EXPECT_EQ(of_candidate[0], 1);
    EXPECT_EQ(of_candidate[3], 1);
    EXPECT_NEAR(static_cast<double>(of_cells), 10, 1);
  }
  Strata cells;
  append(Kind::kDiffuse, 0, {1000, 0.001f}, cells);
  EXPECT_EQ(cap_candidates(cells, 10), cells.total() / 10);
  EXPECT_EQ(cells.columns(cells.segments()[0]).weights[0], 1000);
}

TEST(RayComb, FewerCandidatesThanRaysHaveOneEach) {
  RayComb comb;
  for (int k = 0; k < 50; ++k) {
    Strata strata;
    append(Kind::kLocal, 0, {3, 2, 1}, strata);
    std::vector<int> hits(16);
    comb.walk(strata, 10, (k + 0.5) / 50, [&](const SegmentHits& found) {
      for (const Comb::Hit& hit : found.hits) ++hits.at(hit.stratum);
    });
    EXPECT_LE(*std::max_element(hits.begin(), hits.end()), 1);
    EXPECT_EQ(hits[0], 1);
  }
}

TEST(RayComb, SendsNothingWhereNothingIsUncertain) {
  RayComb comb;
  size_t hits = 0;
  const auto count = [&](const SegmentHits& found) { hits += found.hits.size(); };
  Strata strata;
  comb.walk(strata, 10, 0.5, count);
  append(Kind::kDiffuse, 0, {0, 0, 0}, strata);
  append(Kind::kGlossy, 0, {0, 0, 0}, strata);
  comb.walk(strata, 10, 0.5, count);
  append(Kind::kGlossy, 0, {1, 2}, strata);
  comb.walk(strata, 0, 0.5, count);
  EXPECT_EQ(hits, 0u);
}

}  // namespace
}  // namespace kinome::test::ray_comb_test

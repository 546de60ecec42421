// Compares kernels over the clusters of a cut, for each instruction set, with the same formulas for
// one cluster after the other.
#include "clustered/kernels/cluster_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "clustered/kernels/cluster_formulas.h"

namespace kinome::cluster_kernels_test {
namespace {

/// Random clusters that no cut would contain, some of them without light.
struct Clusters {
  static constexpr size_t kRows = 7;
  std::vector<std::vector<float>> columns;
  std::vector<float> hits;
  simd::ClusterColumns clusters;
  simd::LocalColumns local;
  std::mt19937 rng{5};

  Clusters() {
    const auto column = [&](float low, float high) {
      std::vector<float>& values = columns.emplace_back(kRows * kBlockLanes);
      std::uniform_real_distribution<float> value(low, high);
      for (float& v : values) v = value(rng);
      return values.data();
    };
    columns.reserve(32);
    clusters.rows = kRows;
    for (int axis = 0; axis < 3; ++axis) {
      clusters.mean[axis] = column(-1, 1);
      clusters.lo[axis] = column(-1.2f, -0.2f);
      clusters.hi[axis] = column(-0.2f, 1.2f);
      local.half[axis] = column(0, 0.3f);
      local.normal[axis] = column(-1, 1);
    }
    float* const weight = column(0.1f, 2);
    for (size_t i = 0; i < kRows * kBlockLanes; i += 5) weight[i] = 0;
    clusters.weight = weight;
    clusters.inverse_extent = column(0.5f, 3);
    local.cone_sine = column(0, 1);
    local.inverse_one_plus_sine = column(0.5f, 1);
    local.reach = column(0, 0.5f);
    local.min_distance2 = column(1e-3f, 0.5f);
    std::uniform_int_distribution<int> few(0, 3);
    for (size_t i = 0; i < kRows * kBlockLanes; ++i) hits.push_back(static_cast<float>(few(rng)));
  }

  simd::ImportanceQuery query(bool glossy) {
    std::normal_distribution<float> gauss;
    simd::ImportanceQuery q{};
    float length2 = 0;
    for (float& n : q.normal) n = gauss(rng), length2 += n * n;
    for (float& n : q.normal) n /= std::sqrt(length2);
    for (float& p : q.position) p = 0.5f * gauss(rng);
    q.diffuse = 0.3f;
    q.unit_area = 0.7f;
    if (glossy) {
      q.glossy_hit = 0.1f;
      q.glossy_floor = 0.02f;
      q.hits = hits.data();
    }
    return q;
  }
};

struct Sums {
  std::vector<float> columns = std::vector<float>(Clusters::kRows * kBlockLanes);
  std::array<float, kBlockLanes> lanes{};
  float total = 0;
};

/// Both sum in the same order and differ only by fused multiply-adds. These change a dot product by
/// some units of 2^-24. If an importance cancels to a hundredth of its terms, the error is a
/// hundred times larger: 1e-5.
void expect_same(const Sums& found, const Sums& expected) {
  EXPECT_NEAR(found.total, expected.total, 1e-5f * expected.total);
  for (size_t lane = 0; lane < kBlockLanes; ++lane) {
    EXPECT_NEAR(found.lanes[lane], expected.lanes[lane], 1e-5f * expected.total);
  }
  for (size_t i = 0; i < found.columns.size(); ++i) {
    EXPECT_NEAR(found.columns[i], expected.columns[i], 1e-5f * expected.total);
    const bool grows =
        i < kBlockLanes ? found.columns[i] > 0 : found.columns[i] > found.columns[i - kBlockLanes];
    const bool grew = i < kBlockLanes ? expected.columns[i] > 0
                                      : expected.columns[i] > expected.columns[i - kBlockLanes];
    EXPECT_EQ(grows, grew) << i;
  }
}

TEST(ClusterKernels, ImportanceEqualsThatOfSingleClusters) {
  Clusters c;
  for (int k = 0; k < 50; ++k) {
    const simd::ImportanceQuery query = c.query(k % 2 == 1);
    Sums found, expected;
    found.total =
        simd::cluster_importance(c.clusters, query, found.columns.data(), found.lanes.data());
    expected.total = simd::sum_importances<float>(simd::DistantImportance<float>{c.clusters, query},
                                                  Clusters::kRows, expected.columns.data(),
                                                  expected.lanes.data());
    ASSERT_GT(expected.total, 0);
    expect_same(found, expected);
  }
}

TEST(ClusterKernels, LocalImportanceEqualsThatOfSingleClusters) {
  Clusters c;
  for (int k = 0; k < 50; ++k) {
    const simd::ImportanceQuery query = c.query(k % 2 == 1);
    Sums found, expected;
    found.total = simd::local_cluster_importance(c.clusters, c.local, query, found.columns.data(),
                                                 found.lanes.data());
    expected.total = simd::sum_importances<float>(
        simd::LocalImportance<float>{c.clusters, c.local, query}, Clusters::kRows,
        expected.columns.data(), expected.lanes.data());
    ASSERT_GT(expected.total, 0);
    expect_same(found, expected);
  }
}

TEST(ClusterKernels, NoImportanceIsNone) {
  Clusters c;
  simd::ImportanceQuery query = c.query(false);
  const std::vector<float> dark(Clusters::kRows * kBlockLanes, 0.f);
  c.clusters.weight = dark.data();
  Sums found;
  EXPECT_EQ(simd::cluster_importance(c.clusters, query, found.columns.data(), found.lanes.data()),
            0);
}

}  // namespace
}  // namespace kinome::cluster_kernels_test

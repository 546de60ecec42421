#include "kinome/sphere_partition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "kinome/error.h"
#include "support/statistics.h"

namespace kinome::sphere_partition_test {
namespace {

constexpr uint32_t kSizes[] = {1, 2, 3, 4, 5, 6, 7, 12, 100, 511, 512, 32768, 32769, 1u << 20};

std::vector<uint32_t> cells_to_try(uint32_t size) {
  std::vector<uint32_t> cells;
  if (size <= 40000) {
    for (uint32_t i = 0; i < size; ++i) cells.push_back(i);
    return cells;
  }
  std::mt19937 rng(1);
  for (uint32_t i = 0; i < 1000; ++i) {  // all cells near both poles, the rest at random
    cells.push_back(i);
    cells.push_back(size - 1 - i);
    for (int k = 0; k < 20; ++k) cells.push_back(rng() % size);
  }
  return cells;
}

TEST(SpherePartition, CentresAndSamplesLieInTheirCells) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> uniform(0, 1);
  // Also tests the ends of [0, 1), where rounding could move a point into the next cell.
  const float ends[] = {0.f, 1e-7f, 0.5f, kOneMinusEpsilon};
  for (const uint32_t size : kSizes) {
    const SpherePartition partition(size);
    ASSERT_EQ(partition.size(), size);
    for (const uint32_t i : cells_to_try(size)) {
      const Vec3 c = partition.centre(i);
      ASSERT_NEAR(glm::length(c), 1, 1e-6) << "cell " << i << " of " << size;
      ASSERT_EQ(partition.cell_of(c), i) << "centre, size " << size;
      for (int k = 0; k < 4; ++k) {
        const Vec2 u(std::min(uniform(rng), kOneMinusEpsilon),
                     std::min(uniform(rng), kOneMinusEpsilon));
        const Vec3 d = partition.sample(i, u);
        ASSERT_NEAR(glm::length(d), 1, 1e-6);
        ASSERT_EQ(partition.cell_of(d), i) << "size " << size << ", u " << u.x << " " << u.y;
        const Vec2 corner(ends[rng() % 4], ends[rng() % 4]);
        ASSERT_EQ(partition.cell_of(partition.sample(i, corner)), i)
            << "size " << size << ", u " << corner.x << " " << corner.y;
      }
    }
  }
}

TEST(SpherePartition, TakesAnySizeUpTo4096) {
  for (uint32_t size = 1; size <= 4096; ++size) {
    const SpherePartition partition(size);
    ASSERT_EQ(partition.first_of_ring(0), 0u);
    ASSERT_EQ(partition.first_of_ring(partition.ring_count()), size);
    for (uint32_t r = 0; r < partition.ring_count(); ++r) {
      ASSERT_LT(partition.first_of_ring(r), partition.first_of_ring(r + 1)) << size;
    }
    ASSERT_EQ(partition.cell_of(partition.centre(size / 2)), size / 2);
  }
}

TEST(SpherePartition, RefusesToBeEmpty) {
  EXPECT_THROW(SpherePartition(0), Error);
}

TEST(SpherePartition, HoldsAxesAndVectorsOffUnitLength) {
  for (const uint32_t size : kSizes) {
    const SpherePartition partition(size);
    EXPECT_LT(partition.cell_of(Vec3(0, 1, 0)), partition.first_of_ring(1));
    EXPECT_GE(partition.cell_of(Vec3(0, -1, 0)),
              partition.first_of_ring(partition.ring_count() - 1));
    for (const Vec3& d : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1),
                          Vec3(-0.f, 0, -1), Vec3(0, 1.0000002f, 0), Vec3(0, -1.0000002f, 0)}) {
      EXPECT_LT(partition.cell_of(d), size);
    }
  }
}

// All cells have equal areas: uniform directions fall into all cells alike, by cell_of().
TEST(SpherePartition, CellsHaveEqualAreas) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const uint32_t size : {1u, 2u, 3u, 7u, 100u, 513u, 4099u}) {
    const SpherePartition partition(size);
    std::vector<double> observed(size), expected(size, 3e5 / size);
    for (int i = 0; i < 300000; ++i) {
      const double y = 1 - 2 * uniform(rng), phi = 2 * kPi * uniform(rng);
      const double s = std::sqrt(1 - y * y);
      observed[partition.cell_of(Vec3(s * std::cos(phi), y, s * std::sin(phi)))] += 1;
    }
    if (size == 1) continue;
    const auto verdict = test::chi2_test(observed, expected, 1e-4);
    EXPECT_TRUE(verdict.passed) << size << ": " << verdict.text;
  }
}

// Samples are uniform within each cell. A finer histogram of the sphere (y by phi) is flat, and so
// is one of a single cell near the pole.
TEST(SpherePartition, SamplesAreUniform) {
  for (const uint32_t size : {1u, 5u, 300u}) {
    const SpherePartition partition(size);
    std::mt19937 rng(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    test::SphereChi2 chi2;
    chi2.sample = [&](float u1, Vec2 u2) {
      const auto cell = std::min(static_cast<uint32_t>(u1 * size), size - 1);
      return partition.sample(cell, u2);
    };
    chi2.pdf = [](const Vec3&) { return 1 / (4 * kPi); };
    const auto verdict = test::sphere_chi2_test(chi2, 1e-4);
    EXPECT_TRUE(verdict.passed) << size << ": " << verdict.text;
  }
}

TEST(SpherePartition, SamplesAreUniformWithinSmallCells) {
  constexpr uint32_t kSize = 1u << 20;
  const SpherePartition partition(kSize);
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const uint32_t ring : {0u, 1u, partition.ring_count() / 4, partition.ring_count() / 2,
                              partition.ring_count() - 1}) {
    const uint32_t first = partition.first_of_ring(ring);
    const double in_ring = partition.first_of_ring(ring + 1) - first;
    std::vector<double> observed(64), expected(64, 200000. / 64);
    for (int i = 0; i < 200000; ++i) {
      const Vec2 u(std::min(uniform(rng), kOneMinusEpsilon),
                   std::min(uniform(rng), kOneMinusEpsilon));
      const Vec3 d = partition.sample(first, u);
      // Computes the position in the cell from the direction alone, in double precision and exact
      // near the poles.
      const double s2 = double(d.x) * d.x + double(d.z) * d.z;
      const double c = std::abs(d.y) / std::sqrt(s2 + double(d.y) * d.y);
      const double cap = s2 / (s2 + double(d.y) * d.y) / (1 + c);
      const double north = 0.5 * kSize * (d.y > 0 ? cap : 2 - cap);
      double turn = std::atan2(double(d.x), -double(d.z)) / (2 * M_PI);
      if (turn < 0) turn += 1;
      const int a = std::clamp(static_cast<int>(8 * turn * in_ring), 0, 7);
      const int b = std::clamp(static_cast<int>(8 * (north - first) / in_ring), 0, 7);
      observed[8 * a + b] += 1;
    }
    const auto verdict = test::chi2_test(observed, expected, 1e-4);
    EXPECT_TRUE(verdict.passed) << "ring " << ring << ": " << verdict.text;
  }
}

}  // namespace
}  // namespace kinome::sphere_partition_test

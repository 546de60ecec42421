// Tests properties that the tree and the cut have for any light: sums, boxes, ranges, partitions.
#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <set>

#include "clustered/points/light_tree.h"
#include "kinome/error.h"

namespace kinome::light_tree_test {
namespace {

Vec3 random_direction(std::mt19937& rng) {
  std::normal_distribution<float> normal;
  return glm::normalize(Vec3(normal(rng), normal(rng), normal(rng)));
}

/// Returns distant light of `count` points whose powers span `decades` powers of ten.
LightPoints random_light(uint32_t count, uint32_t seed, float decades = 4) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> unit;
  LightPoints points;
  for (uint32_t i = 0; i < count; ++i) {
    points.position.push_back(random_direction(rng));
    const float scale = std::pow(10.f, decades * (unit(rng) - 0.5f));
    points.power.push_back(scale * Rgb(unit(rng), unit(rng), unit(rng) - 0.05f));
    points.extent.push_back(4 * kPi / static_cast<float>(count));
  }
  return points;
}

bool inside(const Aabb& box, const Vec3& p) {
  return glm::all(glm::lessThanEqual(box.lo, p)) && glm::all(glm::lessThanEqual(p, box.hi));
}

class LightTreeOf : public testing::TestWithParam<uint32_t> {};

TEST_P(LightTreeOf, CellsSumUpTheirPoints) {
  const LightTree tree(random_light(GetParam(), 1));
  ASSERT_EQ(tree.cells().size(), 2 * GetParam() - 1);
  double mean = 0;
  for (uint32_t i = 0; i < GetParam(); ++i) mean += tree.point_weight(i) / GetParam();
  for (const LightCell& cell : tree.cells()) {
    double weight = 0, extent = 0, squares = 0;
    for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      weight += tree.point_weight(i);
      extent += tree.points().extent[i];
    }
    for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      const double d = tree.point_weight(i) - weight / cell.count;
      squares += d * d / (mean * mean);
    }
    // Sums are accumulated in double precision and rounded once.
    EXPECT_NEAR(cell.weight, weight, 1e-6 * weight);
    EXPECT_NEAR(cell.extent, extent, 1e-6 * extent);
    EXPECT_NEAR(cell.variance, squares, 1e-5 * squares + 1e-30);
  }
}

TEST_P(LightTreeOf, BoxesHoldTheirPointsAndTheirChildren) {
  const LightTree tree(random_light(GetParam(), 2));
  for (const LightCell& cell : tree.cells()) {
    for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      ASSERT_TRUE(inside(cell.box, tree.points().position[i]));
    }
    if (cell.left == 0) continue;
    for (const uint32_t child : {cell.left, cell.left + 1}) {
      EXPECT_TRUE(inside(cell.box, tree.cells()[child].box.lo));
      EXPECT_TRUE(inside(cell.box, tree.cells()[child].box.hi));
    }
  }
}

TEST_P(LightTreeOf, IsACompleteBinaryTree) {
  const LightTree tree(random_light(GetParam(), 3));
  int shallowest = 1000, deepest = 0;
  uint32_t leaves = 0;
  const auto visit = [&](auto&& self, uint32_t index, int depth) -> void {
    const LightCell& cell = tree.cells()[index];
    if (cell.left == 0) {
      EXPECT_EQ(cell.count, 1u);
      ++leaves;
      shallowest = std::min(shallowest, depth);
      deepest = std::max(deepest, depth);
      return;
    }
    const LightCell& a = tree.cells()[cell.left];
    const LightCell& b = tree.cells()[cell.left + 1];
    EXPECT_EQ(a.first, cell.first);
    EXPECT_EQ(b.first, a.first + a.count);
    EXPECT_EQ(a.count + b.count, cell.count);
    self(self, cell.left, depth + 1);
    self(self, cell.left + 1, depth + 1);
  };
  visit(visit, 0, 0);
  EXPECT_EQ(leaves, GetParam());
  EXPECT_LE(deepest - shallowest, 1);
}

TEST_P(LightTreeOf, KeepsEveryPoint) {
  LightPoints points = random_light(GetParam(), 4);
  const LightTree tree(points);
  std::multiset<float> before, after;
  for (const Rgb& p : points.power) before.insert(p.x);
  for (const Rgb& p : tree.points().power) after.insert(p.x);
  EXPECT_EQ(before, after);
}

TEST_P(LightTreeOf, CutsArePartitionsOfTheRightSize) {
  const LightTree tree(random_light(GetParam(), 5));
  for (const CutCriterion criterion : {CutCriterion::kVariance, CutCriterion::kLuminance}) {
    for (const uint32_t size : {1u, 2u, 17u, 512u, 100000u}) {
      const std::vector<uint32_t> cut = select_cut(tree, size, criterion);
      EXPECT_EQ(cut.size(), std::min(size, GetParam()));
      uint32_t next = 0;
      for (const uint32_t index : cut) {
        EXPECT_EQ(tree.cells()[index].first, next);
        next += tree.cells()[index].count;
      }
      EXPECT_EQ(next, GetParam());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, LightTreeOf, testing::Values(1u, 2u, 3u, 5u, 64u, 1000u, 4096u));

TEST(LightCutSelection, SplitsTheHighestCriterionFirst) {
  const LightTree tree(random_light(2048, 6));
  for (const CutCriterion criterion : {CutCriterion::kVariance, CutCriterion::kLuminance}) {
    const auto value = [&](uint32_t i) {
      const LightCell& c = tree.cells()[i];
      return criterion == CutCriterion::kVariance ? c.variance : c.weight;
    };
    const auto cut = select_cut(tree, 100, criterion);
    const std::set<uint32_t> in_cut(cut.begin(), cut.end());
    // Each split cell has a criterion at least as high as each inner cell of the cut, because a
    // parent's criterion is never below its child's.
    float highest_standing = 0;
    for (const uint32_t i : cut) {
      if (tree.cells()[i].left != 0) highest_standing = std::max(highest_standing, value(i));
    }
    const auto check = [&](auto&& self, uint32_t i) -> void {
      if (in_cut.contains(i)) return;
      EXPECT_GE(value(i), highest_standing);
      self(self, tree.cells()[i].left);
      self(self, tree.cells()[i].left + 1);
    };
    check(check, 0);
  }
}

TEST(LightCutSelection, UniformLightIsCutEvenly) {
  LightPoints points = random_light(1024, 7);
  for (Rgb& p : points.power) p = Rgb(1.f);
  const LightTree tree(points);
  for (const uint32_t i : select_cut(tree, 64, CutCriterion::kVariance)) {
    EXPECT_EQ(tree.cells()[i].count, 16u);
  }
}

TEST(LightTree, CoincidentPointsAndExtremePowers) {
  LightPoints points = random_light(500, 8, 60);  // 1e-30 to 1e30
  for (Vec3& p : points.position) p = Vec3(0, 1, 0);
  const LightTree tree(points);
  double sum = 0;
  for (uint32_t i = 0; i < 500; ++i) sum += tree.point_weight(i);
  EXPECT_NEAR(tree.cells()[0].weight, sum, 1e-6 * sum);
  EXPECT_EQ(select_cut(tree, 64, CutCriterion::kLuminance).size(), 64u);
}

/// Scales the light by 2^±100. Its squares exceed the range of single precision.
TEST(LightCutSelection, DoesNotDependOnTheUnitOfLight) {
  const LightPoints points = random_light(2048, 11);
  const auto expected = select_cut(LightTree(points), 100, CutCriterion::kVariance);
  for (const int exponent : {-100, 100}) {
    LightPoints scaled = points;
    for (Rgb& p : scaled.power) p *= std::ldexp(1.f, exponent);
    EXPECT_EQ(select_cut(LightTree(scaled), 100, CutCriterion::kVariance), expected) << exponent;
  }
}

TEST(LightTree, NegativePowerHasImportance) {
  LightPoints points = random_light(4, 9);
  points.power = {Rgb(-1.f), Rgb(0.f), Rgb(1, -1, 1), Rgb(0, 0, -1e-6f)};
  const LightTree tree(points);
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(tree.point_weight(i) > 0, tree.points().power[i] != Rgb(0.f));
  }
}

TEST(LightTree, RefusesPointsThatBreakTheRules) {
  EXPECT_THROW(LightTree{LightPoints{}}, Error);
  const auto broken = [](auto&& change) {
    LightPoints points = random_light(8, 10);
    change(points);
    return points;
  };
  EXPECT_NO_THROW(LightTree(broken([](LightPoints&) {})));
  EXPECT_THROW(LightTree(broken([](LightPoints& p) { p.power.pop_back(); })), Error);
  EXPECT_THROW(LightTree(broken([](LightPoints& p) { p.extent[3] = 0; })), Error);
  EXPECT_THROW(LightTree(broken([](LightPoints& p) { p.power[2].y = NAN; })), Error);
  EXPECT_THROW(LightTree(broken([](LightPoints& p) { p.position[1].x = kInfinity; })), Error);
  EXPECT_THROW(LightTree(broken([](LightPoints& p) { p.kind = LightPoints::Kind::kLocal; })),
               Error);
}

}  // namespace
}  // namespace kinome::light_tree_test

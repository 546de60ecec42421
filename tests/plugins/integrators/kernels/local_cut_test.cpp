// Tests the importance function over clusters of local light. It is positive if any point of the
// cluster can light the shading point, and finite for all positions. Its form factor is the
// documented one.
#include <gtest/gtest.h>

#include <random>

#include "clustered/points/light_cut.h"
#include "support/cluster_pmf.h"
#include "support/statistics.h"

namespace kinome::local_cut_test {
namespace {

/// Returns light points on the walls of a box of the given half size around `centre`, shining
/// inward, and on a sphere in it, shining outward.
LightPoints room_light(uint32_t count, const Vec3& centre = Vec3(0.f), float size = 1) {
  std::mt19937 rng(count);
  std::uniform_real_distribution<float> unit;
  std::normal_distribution<float> gauss;
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  for (uint32_t i = 0; i < count; ++i) {
    Vec3 p, n(0.f);
    if (i % 7 == 6) {
      n = glm::normalize(Vec3(gauss(rng), gauss(rng), gauss(rng)));
      p = 0.3f * n;
    } else {
      const int axis = static_cast<int>(i % 3);
      const float side = i % 2 == 0 ? 1.f : -1.f;
      p = Vec3(2 * unit(rng) - 1, 2 * unit(rng) - 1, 2 * unit(rng) - 1);
      p[axis] = side;
      n[axis] = -side;
    }
    points.position.push_back(centre + size * p);
    points.normal.push_back(n);
    points.power.push_back(Rgb(std::pow(10.f, 4 * unit(rng) - 2)));
    points.extent.push_back(size * size * 25.f / static_cast<float>(count));
  }
  return points;
}

LightCut::Point point_at(const Vec3& position, const Vec3& normal, float diffuse = 0.5f) {
  LightCut::Point point;
  point.position = position;
  point.normal = normal;
  point.diffuse = diffuse;
  return point;
}

/// Returns positions where importance functions have been wrong (Cycles issue 126592): inside a
/// box, on its faces, corners and edges, one ulp outside, and far away.
std::vector<Vec3> critical_positions(const Aabb& box) {
  std::vector<Vec3> places = {box.centre(), box.lo, box.hi, 0.75f * box.lo + 0.25f * box.hi,
                              100.f * box.hi + Vec3(3, 2, 1)};
  for (int axis = 0; axis < 3; ++axis) {
    for (const float bound : {box.lo[axis], box.hi[axis]}) {
      Vec3 face = box.centre();
      face[axis] = bound;
      places.push_back(face);
      face[axis] = std::nextafter(bound, bound == box.lo[axis] ? -kInfinity : kInfinity);
      places.push_back(face);
    }
  }
  return places;
}

bool lights(const LightTree& tree, const LightCell& cell, const LightCut::Point& at) {
  const LightPoints& points = tree.points();
  for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
    const Vec3 to = points.position[i] - at.position;
    if (glm::dot(at.normal, to) > 0 && glm::dot(points.normal[i], to) < 0) return true;
  }
  return false;
}

TEST(LocalCut, IsPositiveWhereAnyPointLightsAndFiniteEverywhere) {
  const LightTree tree(room_light(2000));
  const Vec3 normals[] = {{0, 0, 1}, {0, -1, 0}, glm::normalize(Vec3(1, 2, -3))};
  size_t lit = 0, excluded = 0;
  for (const uint32_t size : {1u, 40u, 2000u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    for (uint32_t chosen = 0; chosen < cut.size(); chosen += 1 + cut.size() / 20) {
      for (const Vec3& place : critical_positions(cut.cell(chosen).box)) {
        for (const Vec3& normal : normals) {
          const LightCut::Point point = point_at(place, normal);
          for (MakeClusterImportance* const make_importance :
               {make_joint_importance, make_brdf_importance}) {
            const ClusterPmf pmf = test::pmf_of(make_importance, cut, point);
            double sum = 0;
            for (uint32_t c = 0; c < cut.size(); ++c) {
              const float p = pmf.empty() ? 0.f : pmf.probability(c);
              ASSERT_TRUE(std::isfinite(p) && p >= 0);
              sum += p;
              const bool is_lit = lights(tree, cut.cell(c), point);
              lit += is_lit;
              excluded += p == 0;
              if (is_lit) {
                ASSERT_GT(p, 0) << "cluster " << c << " of " << size;
              }
            }
            if (!pmf.empty()) {
              // The total is a sum of 16 lanes, and a probability is a difference and a quotient.
              // Each has a rounding error of 2^-24.
              ASSERT_NEAR(sum, 1, 18 * 0x1p-24);
            }
          }
        }
      }
    }
  }
  EXPECT_GT(lit, 10000u);
  EXPECT_GT(excluded, 10000u);  // the test would fail if all clusters got samples
}

/// A cluster whose mean is at one end of its box. The farthest point is a whole diagonal away from
/// it, and is the only one that faces the shading point.
TEST(LocalCut, ReachesTheFarEndOfASkewedCluster) {
  const float tilt = glm::radians(28.f);
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  points.position.assign(99, Vec3(0, 0, 0.5f));
  points.normal.assign(99, Vec3(0, 0, 1));
  points.position.push_back({1, 0, 0.5f});
  points.normal.push_back({-std::sin(tilt), 0, std::cos(tilt)});
  points.power.assign(100, Rgb(1.f));
  points.extent.assign(100, 1e-6f);
  const LightTree tree(points);
  const LightCut cut(tree, 1, CutCriterion::kVariance);
  const LightCut::Point at = point_at(Vec3(0.f), {0, 0, 1});
  ASSERT_TRUE(lights(tree, cut.cell(0), at));
  const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, at);
  EXPECT_FALSE(pmf.empty());
}

TEST(LocalCut, SamplesByItsProbabilities) {
  const LightTree tree(room_light(600));
  const LightCut cut(tree, 60, CutCriterion::kVariance);
  for (const Vec3& place : critical_positions(cut.cell(30).box)) {
    const ClusterPmf pmf =
        test::pmf_of(make_joint_importance, cut, point_at(place, glm::normalize(Vec3(1, 2, -3))));
    if (pmf.empty()) continue;
    constexpr int kSamples = 100000;
    std::vector<double> observed(600), expected(600);
    std::mt19937 rng(5);
    std::uniform_real_distribution<float> unit(0, kOneMinusEpsilon);
    for (int i = 0; i < kSamples; ++i) {
      const float u = unit(rng);
      const test::DrawnPoint drawn = test::draw_one(cut, pmf, {u, unit(rng)});
      ++observed[drawn.point];
      ASSERT_FLOAT_EQ(1 / drawn.weight, cut.point_probability(pmf, drawn.point));
    }
    for (uint32_t i = 0; i < 600; ++i) expected[i] = kSamples * cut.point_probability(pmf, i);
    const test::Verdict verdict = test::chi2_test(observed, expected, 1e-5);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

/// A distant wall of identical points. The pmf over leaves is the light times the form factor of
/// each leaf.
TEST(LocalCut, FormFactorsOfSmallClustersAreThePoints) {
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  for (int i = 0; i < 8; ++i) {
    points.position.push_back({-0.7f + 0.2f * static_cast<float>(i), 0, 1});
    points.normal.push_back(glm::normalize(Vec3(0.1f * static_cast<float>(i), 0, -1)));
    points.power.push_back(Rgb(1 + static_cast<float>(i)));
    points.extent.push_back(1e-8f);
  }
  const LightTree tree(points);
  const LightCut cut(tree, 8, CutCriterion::kVariance);
  const LightCut::Point at = point_at({0.3f, -0.2f, 0}, glm::normalize(Vec3(0.5f, 0, 1)));
  const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, at);
  std::vector<double> gamma;
  double total = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    const Vec3 to = tree.points().position[i] - at.position;
    const double d2 = glm::dot(to, to);
    const double g = glm::dot(at.normal, to) * -glm::dot(tree.points().normal[i], to) / (d2 * d2);
    gamma.push_back(tree.points().power[i].x * std::max(g, 0.));
    total += gamma.back();
  }
  for (uint32_t i = 0; i < 8; ++i) {
    const double expected = (gamma[i] / total + 1e-3 / 8) / (1 + 1e-3);
    // The cone of a single normal is widened by an angle of 1.4e-3 against rounding. The largest
    // angle between a normal and the direction to the shading point is 57 degrees. Its cosine grows
    // by tan(57°) 1.4e-3.
    EXPECT_NEAR(pmf.probability(i), expected, 2.2e-3 * expected);
  }
}

/// Powers of two don't change any rounding.
TEST(LocalCut, DoesNotDependOnTheUnitOfLength) {
  const LightCut::Point near = point_at({0.4f, -0.3f, 0.2f}, glm::normalize(Vec3(1, 2, -3)));
  const LightTree tree(room_light(500));
  const LightCut cut(tree, 50, CutCriterion::kLuminance);
  const ClusterPmf expected = test::pmf_of(make_joint_importance, cut, near);
  for (const float scale : {0x1p-20f, 0x1p20f}) {
    const LightTree scaled_tree(room_light(500, Vec3(0.f), scale));
    const LightCut scaled(scaled_tree, 50, CutCriterion::kLuminance);
    const ClusterPmf pmf =
        test::pmf_of(make_joint_importance, scaled, point_at(scale * near.position, near.normal));
    for (uint32_t c = 0; c < cut.size(); ++c) {
      EXPECT_EQ(pmf.probability(c), expected.probability(c));
    }
  }
}

TEST(LocalCut, LobeRaysCountAtAnyDistance) {
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  for (const float z : {1.f, 3.f, 50.f}) {
    for (const float x : {-0.5f, 0.5f}) {
      points.position.push_back({x * z, 0, z});
      points.normal.push_back({0, 0, -1});
      points.power.push_back(Rgb(1.f));
      points.extent.push_back(0.01f);
    }
  }
  const LightTree tree(points);
  const LightCut cut(tree, 6, CutCriterion::kVariance);
  const Vec3 d = glm::normalize(Vec3(0.5f, 0, 1));
  LightCut::Point point = point_at({0, 0, 0}, {0, 0, 1}, 0);
  point.glossy = 1;
  point.lobe = {&d.x, &d.y, &d.z, 1};
  const auto importance = make_joint_importance();
  importance->prepare(cut);
  ClusterPmf pmf;
  importance->weigh(point, pmf);
  for (uint32_t c = 0; c < 6; ++c) {
    EXPECT_EQ(pmf.hits(c), cut.cell(c).mean.x > 0 ? 1 : 0);
  }
  point.position.x = 0.01f;  // this ray misses all patches
  point.position.y = 0.2f;
  importance->weigh(point, pmf);
  for (uint32_t c = 0; c < 6; ++c) EXPECT_EQ(pmf.hits(c), 0);
}

TEST(LocalCut, CoincidentLightsAndOneLight) {
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  for (int i = 0; i < 64; ++i) {
    points.position.push_back({0, 0, 1});
    points.normal.push_back(i % 2 == 0 ? Vec3(0, 0, -1) : Vec3(0, 0, 1));
    points.power.push_back(Rgb(1.f));
    points.extent.push_back(0.1f);
  }
  for (const size_t count : {64u, 1u}) {
    points.position.resize(count);
    points.normal.resize(count);
    points.power.resize(count);
    points.extent.resize(count);
    const LightTree tree(points);
    for (const uint32_t size : {1u, 64u}) {
      const LightCut cut(tree, size, CutCriterion::kVariance);
      for (const Vec3& place : {Vec3(0, 0, 1), Vec3(0, 0, 0.999f), Vec3(0, 0, 0)}) {
        const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, point_at(place, {0, 0, 1}));
        if (place.z < 1) {
          ASSERT_FALSE(pmf.empty());
        }
        for (uint32_t c = 0; c < cut.size() && !pmf.empty(); ++c) {
          EXPECT_TRUE(std::isfinite(pmf.probability(c)));
        }
      }
    }
  }
}

}  // namespace
}  // namespace kinome::local_cut_test

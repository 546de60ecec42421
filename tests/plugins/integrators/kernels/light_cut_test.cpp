// Tests the importance function over a cut. It is the exact pmf of the samples, is positive
// if light can be reflected, and is equal on all instruction sets. Lobe hits are compared
// with brute force.
#include "clustered/points/light_cut.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "kinome/sampler.h"
#include "kinome/sphere_partition.h"
#include "support/cluster_pmf.h"
#include "support/statistics.h"

namespace kinome::light_cut_test {
namespace {

LightTree make_tree(uint32_t count, float decades = 6) {
  std::mt19937 rng(count);
  std::uniform_real_distribution<float> unit;
  const SpherePartition sphere(count);
  LightPoints points;
  for (uint32_t i = 0; i < count; ++i) {
    points.position.push_back(sphere.centre(i));
    points.power.push_back(Rgb(std::pow(10.f, decades * (unit(rng) - 0.5f))));
    points.extent.push_back(sphere.cell_solid_angle());
  }
  points.power[count / 2] = Rgb(0.f);
  return LightTree(points);
}

/// Directions around an axis, narrow enough to miss most clusters.
struct Lobe64 {
  std::vector<float> x, y, z;
  explicit Lobe64(const Vec3& axis) {
    std::mt19937 rng(7);
    std::normal_distribution<float> normal(0, 0.2f);
    for (int i = 0; i < 64; ++i) {
      const Vec3 d = glm::normalize(axis + Vec3(normal(rng), normal(rng), normal(rng)));
      x.push_back(d.x);
      y.push_back(d.y);
      z.push_back(d.z);
    }
  }
  LobeDirections batch() const { return {x.data(), y.data(), z.data(), x.size()}; }
};

const Vec3 kNormals[] = {
    {0, 0, 1}, {0, -1, 0}, glm::normalize(Vec3(1, 2, -3)), glm::normalize(Vec3(-1e-3f, 1, 1e-5f))};

TEST(LightCut, PmfSumsToOneAndMatchesSamples) {
  const LightTree tree(make_tree(4096));
  for (const uint32_t size : {1u, 7u, 16u, 100u, 512u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    for (const Vec3& normal : kNormals) {
      const Lobe64 lobe(normal);
      LightCut::Point point{normal, 0.3f, 0.2f, lobe.batch()};
      const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, point);
      ASSERT_FALSE(pmf.empty());
      std::vector<double> expected(size), observed(size);
      double sum = 0;
      constexpr int kSamples = 20000;
      for (uint32_t c = 0; c < size; ++c) {
        expected[c] = kSamples * static_cast<double>(pmf.probability(c));
        sum += pmf.probability(c);
      }
      EXPECT_NEAR(sum, 1, 1e-5);
      for (int i = 0; i < kSamples; ++i) {
        const float u =
            to_unit_float(static_cast<uint32_t>(hash_words(1, size, static_cast<uint64_t>(i))));
        const test::DrawnPoint drawn = test::draw_one(cut, pmf, {u, 0.5f});
        ASSERT_LT(drawn.cluster, size);
        ASSERT_GT(pmf.probability(drawn.cluster), 0);
        ASSERT_EQ(drawn.weight, test::weight_of(cut, pmf, drawn.cluster));
        observed[drawn.cluster] += 1;
      }
      const test::Verdict verdict = test::chi2_test(observed, expected, 1e-4);
      EXPECT_TRUE(verdict.passed) << verdict.text;
    }
  }
}

TEST(LightCut, NeverSamplesAnImpossibleClusterAtTheEnds) {
  const LightTree tree(make_tree(2048));
  const LightCut cut(tree, 333, CutCriterion::kLuminance);
  for (const Vec3& normal : kNormals) {
    const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, {normal, 0.5f, 0});
    double below = 0;
    for (uint32_t c = 0; c < cut.size(); ++c) {
      // Just below, at and above each step of the distribution, and at its ends.
      for (const double u : {below, below - 1e-7, below + 1e-7, 0.0, 1.0}) {
        const float clamped = std::clamp(static_cast<float>(u), 0.f, kOneMinusEpsilon);
        EXPECT_GT(pmf.probability(test::draw_one(cut, pmf, {clamped, 0.5f}).cluster), 0);
      }
      below += pmf.probability(c);
    }
  }
}

TEST(LightCut, NoClusterAboveTheHorizonIsImpossible) {
  const LightTree tree(make_tree(4096, 50));
  for (MakeClusterImportance* const make_importance :
       {make_joint_importance, make_brdf_importance}) {
    for (const uint32_t size : {1u, 64u, 512u}) {
      const LightCut cut(tree, size, CutCriterion::kVariance);
      for (const Vec3& normal : kNormals) {
        for (const float diffuse : {0.f, 1e-20f, 0.7f}) {
          const ClusterPmf pmf = test::pmf_of(make_importance, cut, {normal, diffuse, 0.1f});
          for (uint32_t c = 0; c < size; ++c) {
            for (uint32_t i = cut.cell(c).first; i < cut.cell(c).first + cut.cell(c).count; ++i) {
              if (glm::dot(tree.points().position[i], normal) > 0 && tree.point_weight(i) > 0) {
                ASSERT_GT(pmf.probability(c), 0) << "cluster " << c << ", point " << i;
                ASSERT_GT(cut.point_probability(pmf, i), 0);
              }
            }
          }
        }
      }
    }
  }
}

TEST(LightCut, ClustersBelowTheHorizonAreLeftOut) {
  const LightTree tree(make_tree(4096));
  const LightCut cut(tree, 512, CutCriterion::kLuminance);
  const Vec3 normal = kNormals[2];
  const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, {normal, 0.5f, 0});
  int left_out = 0;
  for (uint32_t c = 0; c < cut.size(); ++c) {
    float best = -kInfinity;
    for (unsigned corner = 0; corner < 8; ++corner) {
      best = std::max(best, glm::dot(cut.cell(c).box.corner(corner), normal));
    }
    if (best < -1e-6f) {
      EXPECT_EQ(pmf.probability(c), 0);
      ++left_out;
    }
  }
  EXPECT_GT(left_out, 50);
}

TEST(LightCut, LobeHitsAgreeWithEveryBoxTested) {
  const LightTree tree(make_tree(4096));
  for (const uint32_t size : {1u, 9u, 65u, 512u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    for (const Vec3& normal : kNormals) {
      const Lobe64 lobe(normal);
      const ClusterPmf pmf =
          test::pmf_of(make_brdf_importance, cut, {normal, 0.1f, 0.5f, lobe.batch()});
      for (uint32_t c = 0; c < size; ++c) {
        // Rays hit boxes on the unit sphere, to a relative precision of 1e-4. A box is certainly
        // hit if it contains the direction, and certainly missed if it is farther away than that.
        const Aabb& box = cut.cell(c).box;
        int certain = 0, possible = 0;
        for (size_t i = 0; i < lobe.x.size(); ++i) {
          const Vec3 d(lobe.x[i], lobe.y[i], lobe.z[i]);
          const float outside = max_component(glm::max(box.lo - d, d - box.hi));
          certain += outside <= -1e-6f;
          possible += outside <= 2e-4f;
        }
        EXPECT_GE(pmf.hits(c), certain);
        EXPECT_LE(pmf.hits(c), possible);
      }
    }
  }
}

TEST(LightCut, ImportanceIsTheDocumentedFormula) {
  const LightTree tree(make_tree(1024, 2));
  const LightCut cut(tree, 100, CutCriterion::kVariance);
  const Vec3 normal = kNormals[3];
  const Lobe64 lobe(normal);
  const float kd = 0.4f, ks = 0.3f;
  for (MakeClusterImportance* const make_importance :
       {make_joint_importance, make_brdf_importance}) {
    const ClusterPmf pmf = test::pmf_of(make_importance, cut, {normal, kd, ks, lobe.batch()});
    std::vector<double> gamma(cut.size());
    double total = 0;
    int active = 0;
    for (uint32_t c = 0; c < cut.size(); ++c) {
      const LightCell& cell = cut.cell(c);
      double corner = -1e9;
      for (unsigned k = 0; k < 8; ++k) {
        corner = std::max<double>(corner, glm::dot(cell.box.corner(k), normal));
      }
      const double weight = make_importance == make_joint_importance ? cell.weight : cell.extent;
      if (corner <= 0 || weight == 0) continue;
      const double form = std::max<double>(glm::dot(cell.mean, normal), corner / 4);
      const double fs =
          (pmf.hits(c) + cell.extent / (2 * kPi)) / ((64 + 1) * static_cast<double>(cell.extent));
      gamma[c] = weight * form * (kd / kPi + ks * fs);
      total += gamma[c];
      ++active;
    }
    for (uint32_t c = 0; c < cut.size(); ++c) {
      const double expected = gamma[c] > 0 ? (gamma[c] / total + 1e-3 / active) / (1 + 1e-3) : 0;
      // Tolerance: a difference of single-precision running sums over one lane's share of the
      // clusters.
      EXPECT_NEAR(pmf.probability(c), expected, 1e-4 * expected + 2e-7);
    }
  }
}

TEST(LightCut, NothingToReflectIsEmpty) {
  LightPoints points;
  points.position = {Vec3(0, 0, 1), Vec3(0, 1, 0)};
  points.power = {Rgb(1.f), Rgb(0.f)};
  points.extent = {0.01f, 0.01f};
  const LightTree tree(points);
  const LightCut cut(tree, 8, CutCriterion::kVariance);
  const auto importance = make_joint_importance();
  importance->prepare(cut);
  ClusterPmf pmf;
  EXPECT_TRUE(importance->weigh({Vec3(0, 0, -1), 0.5f, 0}, pmf).empty());
  importance->weigh({Vec3(0, 0, 1), 0.5f, 0}, pmf);
  EXPECT_FALSE(pmf.empty());
  for (const float u : {0.f, 0.5f, kOneMinusEpsilon}) {
    EXPECT_EQ(tree.points().power[test::draw_one(cut, pmf, {u, u}).point], Rgb(1.f));
  }
  points.power = {Rgb(0.f), Rgb(0.f)};
  const LightTree dark(points);
  const LightCut dark_cut(dark, 8, CutCriterion::kVariance);
  EXPECT_TRUE(test::pmf_of(make_luminance_importance, dark_cut).empty());
}

TEST(LightCut, RadiancesFromTinyToHuge) {
  for (const float scale : {1e-30f, 1.f, 1e30f}) {
    LightPoints points;
    const SpherePartition sphere(256);
    for (uint32_t i = 0; i < 256; ++i) {
      points.position.push_back(sphere.centre(i));
      points.power.push_back(Rgb(scale * static_cast<float>(1 + i % 5)));
      points.extent.push_back(sphere.cell_solid_angle());
    }
    const LightTree tree(points);
    const LightCut cut(tree, 64, CutCriterion::kLuminance);
    const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, {Vec3(0, 0, 1), 0.5f, 0});
    double sum = 0;
    for (uint32_t c = 0; c < 64; ++c) sum += pmf.probability(c);
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

/// Tests both steps, cluster and point, against point_probability.
TEST(LightCut, PointsAreDrawnWithTheirProbability) {
  const LightTree tree(make_tree(1024, 2));
  for (const uint32_t size : {4u, 64u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    const Lobe64 lobe(kNormals[1]);
    for (MakeClusterImportance* const make_importance :
         {make_joint_importance, make_brdf_importance, make_luminance_importance}) {
      const ClusterPmf pmf =
          test::pmf_of(make_importance, cut, {kNormals[1], 0.3f, 0.4f, lobe.batch()});
      constexpr int kSamples = 1000000;
      std::vector<double> observed(1024), expected(1024);
      for (uint32_t i = 0; i < 1024; ++i) {
        expected[i] = kSamples * static_cast<double>(cut.point_probability(pmf, i));
      }
      for (uint64_t i = 0; i < kSamples; ++i) {
        const uint64_t bits = hash_words(3, size, i);
        const test::DrawnPoint drawn =
            test::draw_one(cut, pmf, {to_unit_float(static_cast<uint32_t>(bits)),
                                      to_unit_float(static_cast<uint32_t>(bits >> 32))});
        ASSERT_FLOAT_EQ(1 / drawn.weight, cut.point_probability(pmf, drawn.point));
        observed[drawn.point] += 1;
      }
      const test::Verdict verdict = test::chi2_test(observed, expected, 1e-4);
      EXPECT_TRUE(verdict.passed) << verdict.text;
    }
  }
}

/// Drawing all points at once gives those of single draws, except for their order and for merged
/// duplicates.
TEST(LightCut, ManyPointsAreDrawnAsOneByOne) {
  const LightTree tree(make_tree(2048, 4));
  for (const uint32_t size : {1u, 5u, 16u, 300u, 2048u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    for (const Vec3& normal : kNormals) {
      const ClusterPmf pmf = test::pmf_of(make_joint_importance, cut, {normal, 0.5f, 0});
      std::vector<Vec2> u = {{0, 0}, {kOneMinusEpsilon, kOneMinusEpsilon}, {0.5f, 0.5f}};
      for (uint64_t i = 0; i < 125; ++i) {
        const uint64_t bits = hash_words(size, i);
        // Some of them are concentrated in one region, so that buckets are uneven.
        const float x = to_unit_float(static_cast<uint32_t>(bits));
        u.emplace_back(i % 3 == 0 ? 0.1f * x : x, to_unit_float(static_cast<uint32_t>(bits >> 32)));
      }
      std::map<uint32_t, double> one_by_one, at_once;
      for (const Vec2& number : u) {
        const test::DrawnPoint drawn = test::draw_one(cut, pmf, number);
        one_by_one[drawn.point] += static_cast<double>(drawn.weight) / u.size();
      }
      PointSelection selection;
      cut.sample_points(pmf, u, selection);
      for (size_t i = 0; i < selection.points.size(); ++i) {
        at_once[selection.points[i]] += selection.weights[i];
      }
      ASSERT_EQ(one_by_one.size(), at_once.size());
      for (const auto& [point, weight] : one_by_one) {
        ASSERT_TRUE(at_once.contains(point));
        EXPECT_NEAR(at_once[point], weight, 1e-5 * weight);
      }
    }
  }
}

}  // namespace
}  // namespace kinome::light_cut_test

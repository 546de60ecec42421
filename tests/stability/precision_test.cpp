// Sums and distributions over millions of weights from 1e-30 to 1e30, against long double. No value
// within single precision is lost, and no impossible index is drawn.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "clustered/points/light_cut.h"
#include "clustered/points/light_tree.h"
#include "kinome/bsdf.h"
#include "kinome/distribution.h"
#include "kinome/sampler.h"
#include "kinome/sphere_partition.h"
#include "kinome/warp.h"
#include "support/cluster_pmf.h"
#include "support/render.h"

namespace kinome::test::precision_test {
namespace {

constexpr uint32_t kMany = 1u << 22;

float unit(uint64_t i, uint64_t stream) {
  return to_unit_float(static_cast<uint32_t>(hash_words(i, stream) >> 32));
}

/// Weights from 1e-30 to 1e30, of which a third are 0.
std::vector<float> mixed_weights(uint32_t count, bool with_zeros) {
  std::vector<float> weights(count);
  for (uint32_t i = 0; i < count; ++i) {
    const bool is_zero = with_zeros && unit(i, 1) < 0.333f;
    weights[i] = is_zero ? 0.f : std::pow(10.f, 60 * unit(i, 2) - 30);
  }
  return weights;
}

/// Cumulative distribution of the weights.
std::vector<long double> exact_cdf(const std::vector<float>& weights) {
  std::vector<long double> cdf(weights.size());
  long double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) cdf[i] = sum += static_cast<long double>(weights[i]);
  for (long double& c : cdf) c /= sum;
  return cdf;
}

/// A step of the table is a float with an error of half an ulp of 1, 2^-25. Random numbers have 24
/// bits.
TEST(Precision, DistributionsOfFourMillionCells) {
  for (const bool is_even : {false, true}) {
    std::vector<float> weights = mixed_weights(kMany, true);
    if (is_even) {
      for (float& w : weights) w = w > 0 ? 1.f : 0.f;
    }
    const std::vector<long double> cdf = exact_cdf(weights);
    const GridDistribution distribution(kMany, 1, weights);
    const long double sum =
        std::accumulate(weights.begin(), weights.end(), 0.0L,
                        [](long double s, float w) { return s + static_cast<long double>(w); });
    EXPECT_NEAR(static_cast<double>(static_cast<long double>(distribution.total()) / sum), 1,
                1e-12);
    const auto check = [&](float u) {
      const uint32_t cell = distribution.sample(Vec2(u, 0.5f)).column;
      ASSERT_LT(cell, kMany);
      ASSERT_GT(weights[cell], 0) << "at u = " << u;
      const long double below = cell == 0 ? 0 : cdf[cell - 1];
      ASSERT_GE(static_cast<long double>(u), below - 0x1p-25L);
      ASSERT_LE(static_cast<long double>(u), cdf[cell] + 0x1p-25L);
    };
    for (const float end : {0.f, 0x1p-149f, 0x1p-24f, 0.5f, 1 - 0x1p-23f, kOneMinusEpsilon}) {
      check(end);
    }
    for (uint32_t i = 0; i < 200000; ++i) check(unit(i, 3));
    // At, just below and just above a step.
    for (uint32_t i = 0; i < kMany; i += 37) {
      const auto step = static_cast<float>(cdf[i]);
      for (const float u : {std::nextafter(step, 0.f), step, std::nextafter(step, 2.f)}) {
        if (u < 1) check(u);
      }
    }
  }
}

LightPoints distant_light(uint32_t count) {
  LightPoints points;
  const std::vector<float> weights = mixed_weights(count, false);
  for (uint32_t i = 0; i < count; ++i) {
    points.position.push_back(square_to_uniform_sphere({unit(i, 4), unit(i, 5)}));
    points.power.push_back(Rgb(weights[i]));
    points.extent.push_back(4 * kPi / static_cast<float>(count));
  }
  return points;
}

/// Powers and extents of all cells of any size are summed in double precision and rounded once.
TEST(Precision, TreeOfFourMillionLights) {
  const LightTree tree(distant_light(kMany));
  const std::vector<LightCell>& cells = tree.cells();
  ASSERT_EQ(cells.size(), 2 * size_t{kMany} - 1);
  std::vector<long double> power(kMany + 1), extent(kMany + 1);
  for (uint32_t i = 0; i < kMany; ++i) {
    power[i + 1] = power[i] + static_cast<long double>(tree.point_weight(i));
    extent[i + 1] = extent[i] + static_cast<long double>(tree.points().extent[i]);
  }
  size_t wrong = 0;
  for (const LightCell& cell : cells) {
    // Differences of running sums aren't accurate for small cells, which are summed again.
    long double own = 0, own_extent = 0;
    if (cell.count <= 4096) {
      for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
        own += static_cast<long double>(tree.point_weight(i));
        own_extent += static_cast<long double>(tree.points().extent[i]);
      }
    } else {
      own = power[cell.first + cell.count] - power[cell.first];
      own_extent = extent[cell.first + cell.count] - extent[cell.first];
    }
    wrong += !(std::abs(static_cast<long double>(cell.weight) / own - 1) < 1e-6L);
    wrong += !(std::abs(static_cast<long double>(cell.extent) / own_extent - 1) < 1e-6L);
  }
  EXPECT_EQ(wrong, 0u);
}

/// A pmf over any number of clusters sums to 1, never draws a cluster of importance 0, and draws
/// the correct cluster at its steps.
TEST(Precision, PmfsOverManyClusters) {
  const LightTree tree(distant_light(1u << 18));
  const Vec3 normal = glm::normalize(Vec3(1, -2, 3));
  for (const uint32_t size : {512u, 4096u, 65536u, 262144u}) {
    const LightCut cut(tree, size, CutCriterion::kVariance);
    for (MakeClusterImportance* const make_importance :
         {make_joint_importance, make_brdf_importance}) {
      const ClusterPmf pmf = pmf_of(make_importance, cut, {normal, 0.5f, 0});
      ASSERT_FALSE(pmf.empty());
      long double sum = 0;
      for (uint32_t c = 0; c < size; ++c) {
        const float p = pmf.probability(c);
        ASSERT_TRUE(p >= 0 && p <= 1);
        sum += static_cast<long double>(p);
      }
      EXPECT_NEAR(static_cast<double>(sum), 1, 1e-6) << size;
      for (uint32_t c = 0; c < 4096; ++c) {
        const float at = unit(c, 6);
        for (const float u : {at, std::nextafter(at, 0.f)}) {
          const DrawnPoint drawn = draw_one(cut, pmf, {u, 0.5f});
          ASSERT_LT(drawn.cluster, size);
          ASSERT_GT(pmf.probability(drawn.cluster), 0);
          ASSERT_EQ(drawn.weight, weight_of(cut, pmf, drawn.cluster));
        }
      }
      for (const float u : {0.f, 0x1p-149f, 0x1p-24f, kOneMinusEpsilon}) {
        ASSERT_GT(pmf.probability(draw_one(cut, pmf, {u, 0.5f}).cluster), 0);
      }
    }
  }
}

/// Returns the error of a float in ulps of `b`.
double ulps(float a, double b) {
  const double unit_of_b = std::max(std::ldexp(1., std::ilogb(b) - 23), 0x1p-149);
  return std::abs(a - b) / unit_of_b;
}

/// Compares warps with double precision. Sine and cosine have a rounded argument (2 pi u). Its
/// error is half an ulp of 2 pi, which is an absolute error of 2^-22 in coordinates of any size,
/// plus 3 roundings of the coordinates.
TEST(Precision, WarpsAreTheirFormulas) {
  for (uint32_t i = 0; i < 200000; ++i) {
    const Vec2 u(unit(i, 7), unit(i, 8));
    const double phi = 2 * std::numbers::pi * u.x, v = u.y;
    const Vec3 sphere = square_to_uniform_sphere(u);
    const double r = 2 * std::sqrt(v * (1 - v));
    ASSERT_NEAR(sphere.x, r * std::cos(phi), 1.25 * 0x1p-21);
    ASSERT_NEAR(sphere.y, r * std::sin(phi), 1.25 * 0x1p-21);
    ASSERT_NEAR(sphere.z, 1 - 2 * v, 0x1p-24);
    const Vec3 power = square_to_cosine_power(u, 1e6f);
    const double log_cos = std::log1p(-v) / (1e6 + 1);
    const double sine = std::sqrt(-std::expm1(2 * log_cos));
    ASSERT_NEAR(power.x, sine * std::cos(phi), 1.25 * 0x1p-20 * sine + 1e-30);
  }
}

/// Compares values of BSDFs with double precision, for directions that are exact in floats.
TEST(Precision, BsdfsAreTheirFormulas) {
  constexpr double kInvPiD = 1 / std::numbers::pi;
  const auto phong = make<Bsdf>(
      "<bsdf type='phong'><float name='exponent' value='100'/>"
      "<float name='diffuse_reflectance' value='.25'/>"
      "<float name='specular_reflectance' value='.5'/></bsdf>");
  const auto diffuse =
      make<Bsdf>("<bsdf type='diffuse'><float name='reflectance' value='.5'/></bsdf>");
  double worst_diffuse = 0, worst_phong = 0;
  for (uint32_t i = 0; i < 100000; ++i) {
    SurfaceInteraction si;
    si.wi = square_to_uniform_hemisphere({unit(i, 9), unit(i, 10)});
    const Vec3 wo = square_to_uniform_hemisphere({unit(i, 11), unit(i, 12)});
    if (!(si.wi.z > 1e-3f && wo.z > 1e-3f)) continue;
    const double cosine = wo.z;
    worst_diffuse = std::max(
        worst_diffuse, ulps(diffuse->eval_pdf(si, Lobe::kAll, wo).f.x, .5 * kInvPiD * cosine));
    // The lobe is defined by the chord, because rounding changes the length of directions.
    const glm::dvec3 difference = glm::dvec3(-si.wi.x, -si.wi.y, si.wi.z) - glm::dvec3(wo);
    const double s = 0.5 * glm::dot(difference, difference);
    const double lobe = s < 1 ? std::pow(1 - s, 100) : 0;
    if (lobe < 1e-19 && lobe > 0) continue;  // cut off at 1e-20
    const double expected = (.25 * kInvPiD + .5 * 102 * 0.5 * kInvPiD * lobe) * cosine;
    worst_phong = std::max(worst_phong, ulps(phong->eval_pdf(si, Lobe::kAll, wo).f.x, expected));
  }
  // Three roundings.
  EXPECT_LE(worst_diffuse, 2);
  // s has an error of several ulps. Multiplied by 100 / (1 - s), where the lobe still exceeds the
  // diffuse part, that is several hundred ulps of the exponent.
  EXPECT_LE(worst_phong, 400);
}

}  // namespace
}  // namespace kinome::test::precision_test

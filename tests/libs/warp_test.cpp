#include "kinome/warp.h"

#include <gtest/gtest.h>

#include "support/statistics.h"

namespace kinome::test::warp_test {
namespace {

constexpr double kAlpha = 1e-4;

struct Warp {
  const char* name;
  std::function<Vec3(Vec2)> sample;
  std::function<float(const Vec3&)> pdf;
};

const std::vector<Warp>& warps() {
  static const std::vector<Warp> all{
      {"cosine hemisphere", square_to_cosine_hemisphere,
       [](const Vec3& d) { return cosine_hemisphere_pdf(d.z); }},
      {"uniform hemisphere", square_to_uniform_hemisphere,
       [](const Vec3& d) { return d.z > 0 ? kUniformHemispherePdf : 0.f; }},
      {"uniform sphere", square_to_uniform_sphere, [](const Vec3&) { return kUniformSpherePdf; }},
      {"cosine power", [](Vec2 u) { return square_to_cosine_power(u, 12); },
       [](const Vec3& d) { return d.z > 0 ? 13 * 0.5f * kInvPi * std::pow(d.z, 12.f) : 0.f; }},
  };
  return all;
}

TEST(Warp, DensitiesMatchSamples) {
  for (const Warp& warp : warps()) {
    SphereChi2 test;
    test.sample = [&](float, Vec2 u) { return warp.sample(u); };
    test.pdf = warp.pdf;
    test.samples = 200000;
    test.subdivide = 4;
    const Verdict chi2 = sphere_chi2_test(test, kAlpha);
    EXPECT_TRUE(chi2.passed) << warp.name << ": " << chi2.text;
    const Verdict jacobian =
        jacobian_test([&](Vec2 u) { return std::optional(warp.sample(u)); }, warp.pdf, 2000, 1e-3);
    EXPECT_TRUE(jacobian.passed) << warp.name << ": " << jacobian.text;
  }
}

TEST(Warp, DiskIsInverted) {
  for (int x = 0; x <= 64; ++x) {
    for (int y = 0; y <= 64; ++y) {
      const Vec2 u(static_cast<float>(x) / 64, static_cast<float>(y) / 64);
      const Vec2 back = disk_to_square_concentric(square_to_disk_concentric(u));
      EXPECT_NEAR(back.x, u.x, 4e-7f) << u.x << ", " << u.y;
      EXPECT_NEAR(back.y, u.y, 4e-7f) << u.x << ", " << u.y;
    }
  }
}

TEST(Warp, EdgesAreFiniteUnitVectors) {
  for (const Warp& warp : warps()) {
    for (const float x : {0.f, 0.5f, kOneMinusEpsilon}) {
      for (const float y : {0.f, 0.5f, kOneMinusEpsilon}) {
        const Vec3 d = warp.sample(Vec2(x, y));
        EXPECT_NEAR(glm::length(d), 1, 1e-6f) << warp.name << " at " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(square_to_cosine_hemisphere(Vec2(0)).z, 0);
  EXPECT_NEAR(glm::length(square_to_cosine_power(Vec2(0.3f, 0.7f), 1e6f)), 1, 1e-6f);
  EXPECT_NEAR(glm::length(square_to_cosine_power(Vec2(0.3f, 0.7f), 0)), 1, 1e-6f);
}

// The disk map preserves area: equal areas of the square map to equal areas of the disk.
TEST(Warp, ConcentricDiskIsUniform) {
  constexpr int kRings = 8, kSectors = 16, kSide = 1024;
  std::vector<double> count(kRings * kSectors);
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 p = square_to_disk_concentric(Vec2((static_cast<float>(i % kSide) + 0.5f) / kSide,
                                                  (static_cast<float>(i / kSide) + 0.5f) / kSide));
    const float r2 = glm::dot(p, p);
    ASSERT_LE(r2, 1);
    const float phi = std::atan2(p.y, p.x) / (2 * kPi);
    const int sector = static_cast<int>((phi < 0 ? phi + 1 : phi) * kSectors) % kSectors;
    ++count[static_cast<size_t>(static_cast<int>(r2 * kRings) * kSectors + sector)];
  }
  const double expected = double{kSide} * kSide / (kRings * kSectors);
  // A regular grid: only cells on a border can be counted wrongly, about 2 sqrt(expected) of them.
  for (const double n : count) EXPECT_NEAR(n, expected, 0.03 * expected);
}

}  // namespace
}  // namespace kinome::test::warp_test

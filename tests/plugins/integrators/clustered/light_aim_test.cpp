// Tests of aims: the spheres, and the densities of rays that are aimed at them.
#include "clustered/product/lights/light_aim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "plugins/integrators/kernels/kernel_helpers.h"
#include "support/statistics.h"

namespace kinome::test::light_aim_test {
namespace {

constexpr double kAlpha = 1e-4;  // false-alarm rate of each statistical test
constexpr float kSpherePdf = 1 / (4 * kPi);

/// Returns positions: half within radius 1, a quarter each within 3 and 20, and one very far away.
std::vector<WeightedPosition> positions_of(Random& random) {
  std::vector<WeightedPosition> positions;
  for (int i = 0; i < 8000; ++i) {
    const float radius = i % 4 < 2 ? 1.f : i % 4 == 2 ? 3.f : 20.f;
    positions.push_back({Vec3(5, 6, 7) + radius * random.unit() * random.direction(), 1});
  }
  positions.push_back({Vec3(1e6f, 0, 0), 1});
  return positions;
}

TEST(AimSpheres, EncloseSeenPointsExceptOutliers) {
  Random random(1);
  const auto spheres = aim_spheres(positions_of(random));
  ASSERT_GE(spheres.size(), 2u);
  EXPECT_LE(spheres.size(), static_cast<size_t>(kMaxAimSpheres));
  for (size_t k = 0; k < spheres.size(); ++k) {
    EXPECT_LT(glm::length(spheres[k].centre - Vec3(5, 6, 7)), 0.1f);
    if (k > 0) {
      EXPECT_GT(spheres[k].radius, spheres[k - 1].radius);
    }
  }
  EXPECT_NEAR(spheres.front().radius, 0.84, 0.05);  // includes some of the other positions
  EXPECT_GT(spheres.back().radius, 15);
  EXPECT_LT(spheres.back().radius, 20.5);
}

TEST(AimSpheres, FollowTheWeights) {
  std::vector<WeightedPosition> positions;
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    positions.push_back({random.direction(), 1});
    positions.push_back({Vec3(50) + random.direction(), 1e-6f});
    positions.push_back({Vec3(-50), 0});
  }
  const auto spheres = aim_spheres(positions);
  ASSERT_EQ(spheres.size(), 1u);
  EXPECT_LT(glm::length(spheres[0].centre), 0.2f);
  EXPECT_NEAR(spheres[0].radius, 1, 0.2);
}

TEST(AimSpheres, AreNoneWithoutPositions) {
  EXPECT_TRUE(aim_spheres({}).empty());
  EXPECT_TRUE(aim_spheres({{Vec3(1), 0}}).empty());
  EXPECT_TRUE(aim_spheres({{Vec3(kInfinity), 1}}).empty());
  EXPECT_TRUE(aim_spheres({{Vec3(1), 1}, {Vec3(1), 1}}).empty());
}

TEST(PickAim, RescalesTheNumber) {
  float u = 0.3f;
  EXPECT_EQ(pick_aim(0, u), -1);
  EXPECT_EQ(u, 0.3f);
  constexpr int kDraws = 1 << 16, kBins = 8;
  for (const int count : {1, 3}) {
    std::map<int, std::vector<int>> bins;
    for (int i = 0; i < kDraws; ++i) {
      float v = (static_cast<float>(i) + 0.5f) / kDraws;
      const int aim = pick_aim(count, v);
      ASSERT_GE(aim, -1);
      ASSERT_LT(aim, count);
      ASSERT_TRUE(v >= 0 && v < 1);
      auto& of = bins[aim];
      of.resize(kBins);
      ++of[static_cast<size_t>(v * kBins)];
    }
    for (const auto& [aim, of] : bins) {
      const float share = aim < 0 ? 1 - kAimedShare : kAimedShare / static_cast<float>(count);
      for (const int n : of) EXPECT_NEAR(n, share * kDraws / kBins, 3) << count << ", " << aim;
    }
  }
}

AimCones cones_from(const Vec3& from) {
  AimCones cones;
  for (const AimSphere& sphere : {AimSphere{{3, 1, 0}, .5f}, AimSphere{{3, 1, .3f}, 1.2f}}) {
    cones.add(from, sphere, [](const Vec3& /*axis*/, float /*sine*/) { return kSpherePdf; });
  }
  return cones;
}

/// Samples a direction, aimed or on the whole sphere, and returns its density.
float sample_direction(const AimCones& cones, Random& random, Vec3& d) {
  float u = random.unit();
  const int aim = pick_aim(cones.count(), u);
  const Vec2 at(u, random.unit());
  d = aim >= 0 ? cones.sample(aim, at) : square_to_uniform_sphere(at);
  return cones.pdf(d, kSpherePdf, aim);
}

/// Returns the index of a cell of a grid around the x axis, which is finer toward the axis.
int bin_of(const Vec3& d) {
  const float height = 1 - d.x;  // 0 to 2
  const int ring = height < 0.02f ? 0 : height < 0.1f ? 1 : height < 0.5f ? 2 : 3;
  return 4 * ring + (d.y > 0 ? 2 : 0) + (d.z > 0 ? 1 : 0);
}

/// The mean of 1 / density over the draws in a cell is the cell's solid angle.
TEST(AimCones, HaveTheDensityThatTheyState) {
  const AimCones cones = cones_from(Vec3(0));
  ASSERT_EQ(cones.count(), 2);
  constexpr int kDraws = 1 << 20, kBins = 16;
  Random random(3);
  std::vector<double> sums(kBins), squares(kBins);
  int differ = 0;
  for (int i = 0; i < kDraws; ++i) {
    Vec3 d;
    const double inverse = 1 / static_cast<double>(sample_direction(cones, random, d));
    ASSERT_NEAR(glm::length(d), 1, 1e-5);
    differ += std::abs(cones.pdf(d, kSpherePdf) * inverse - 1) > 1e-6;
    const auto bin = static_cast<size_t>(bin_of(d));
    sums[bin] += inverse;
    squares[bin] += inverse * inverse;
  }
  // The choice of the aim matters only at the rims of cones, where rounding decides.
  EXPECT_LT(differ, 1e-5 * kDraws);
  std::vector<Estimate> measured, expected;
  for (int bin = 0; bin < kBins; ++bin) {
    const double mean = sums[bin] / kDraws;
    measured.push_back({mean, (squares[bin] / kDraws - mean * mean) / kDraws});
    constexpr double kHeights[] = {0.02, 0.08, 0.4, 1.5};
    expected.push_back({kHeights[bin / 4] * static_cast<double>(kPi) / 2, 0});
  }
  const Verdict verdict = z_test(measured, expected, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

TEST(AimCones, OfFarAndTinySpheresStayPrecise) {
  AimCones cones;
  const Vec3 from(300, 800, 500);
  cones.add(from, {Vec3(0, .4f, 0), .01f}, [](const Vec3&, float) { return kSpherePdf; });
  ASSERT_EQ(cones.count(), 1);
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 d = cones.sample(0, {random.unit(), random.unit()});
    const Vec3 to = Vec3(0, .4f, 0) - from;
    // 1e-4 is the single-precision error of a position at this distance.
    EXPECT_LT(glm::length(to - d * glm::dot(to, d)), .01f + 2e-4f);
    EXPECT_GT(cones.pdf(d, kSpherePdf, 0), 1e8f);
  }
}

TEST(AimCones, LeaveOutConesThatDontPay) {
  const auto dark = [](const Vec3&, float) { return 0.f; };
  const auto plain = [](const Vec3&, float) { return kSpherePdf; };
  const auto beam = [](const Vec3&, float) { return 1e4f; };
  AimCones cones;
  cones.add(Vec3(0), {Vec3(2, 0, 0), .2f}, dark);     // no light there
  cones.add(Vec3(0), {Vec3(2, 0, 0), .2f}, beam);     // nearly all light is there
  cones.add(Vec3(0), {Vec3(2, 0, 0), 3.f}, plain);    // contains the emitter
  cones.add(Vec3(0), {Vec3(2, 0, 0), 1.99f}, plain);  // too near
  cones.add(Vec3(0), {Vec3(0), .2f}, plain);
  EXPECT_EQ(cones.count(), 0);
  EXPECT_EQ(cones.pdf(Vec3(0, 0, 1), .7f), .7f);
}

/// The mean of 1 / density over the draws in each part of a disk is its area.
TEST(AimDisks, HaveTheDensityThatTheyState) {
  constexpr float kRadius = 10;
  const float plain = 1 / (kPi * kRadius * kRadius);
  const std::vector<AimSphere> spheres = {{{1, 2, 3}, .2f}, {{1, 2, 3}, 1}, {{0, 0, 0}, 9.5f}};
  const AimDisks disks(spheres, plain);
  EXPECT_EQ(disks.count(), 2) << "the last sphere must not become an aim";
  EXPECT_EQ(AimDisks(std::vector<AimSphere>{{{1, 2, 3}, 1e-3f}}, plain).count(), 0)
      << "rays would miss it because of rounding";
  Random random(5);
  for (const Vec3& d : {Vec3(0, 0, 1), glm::normalize(Vec3(1, -2, .5f))}) {
    const Frame frame = Frame::from_normal(d);
    const Vec3 plane = -20.f * d;
    constexpr int kDraws = 1 << 18, kBins = 8;
    std::vector<double> sums(kBins), squares(kBins);
    for (int i = 0; i < kDraws; ++i) {
      float u = random.unit();
      const int aim = pick_aim(disks.count(), u);
      const Vec2 at(u, random.unit());
      const Vec2 on = kRadius * square_to_disk_concentric(at);
      const Vec3 o =
          aim >= 0 ? disks.sample(aim, at, d, plane) : plane + frame.s * on.x + frame.t * on.y;
      ASSERT_NEAR(glm::dot(o - plane, d), 0, 1e-4);
      // The density is constant along a line.
      const double inverse = 1 / static_cast<double>(disks.pdf(o + 17.f * d, d, aim));
      const Vec3 off = o - spheres[0].centre;
      const float across = glm::length(off - d * glm::dot(off, d));
      const size_t bin = (across < .2f   ? 0
                          : across < .6f ? 2
                          : across < 1   ? 4
                                         : 6) +
                         (glm::dot(off, frame.s) > 0 ? 1 : 0);
      sums[bin] += inverse;
      squares[bin] += inverse * inverse;
    }
    std::vector<Estimate> measured, expected;
    for (int bin = 0; bin < 6; ++bin) {
      const double mean = sums[bin] / kDraws;
      measured.push_back({mean, (squares[bin] / kDraws - mean * mean) / kDraws});
      constexpr double kSquares[] = {.04, .32, .64};
      expected.push_back({kSquares[bin / 2] * static_cast<double>(kPi) / 2, 0});
    }
    const double all = (sums[6] + sums[7]) / kDraws;
    EXPECT_NEAR(all, static_cast<double>(kPi) * 99, 3);
    const Verdict verdict = z_test(measured, expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

}  // namespace
}  // namespace kinome::test::light_aim_test

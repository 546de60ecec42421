// Tests that the choice of light points of a tile is unbiased for any input, and bounded.
#include "clustered/product/choice/local_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "clustered/product/lights/tried_points.h"
#include "stage_tile.h"
#include "support/statistics.h"

namespace kinome::test::local_choice_test {
namespace {

/// Returns a lit panel, a lamp and rough walls around the floor that the tile sees. Light points
/// are near and far, Lambertian and glossy.
std::string corner_xml() {
  return R"(<emitter type="point"><point name="position" x="-1" y="2" z=".5"/></emitter>
      <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/>
      <translate x=".5" y="1.5"/></transform>
      <emitter type="area"><rgb name="radiance" value="3 2 1"/></emitter></shape>
      <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="90"/>
      <translate x="-.4"/></transform><bsdf type="twosided">)" +
         rough_xml("roughconductor", 0.3) + "</bsdf></shape>";
}

/// Each primary looks at the points of a random block. The mean sum of each point's weights is 1.
TEST(LocalChoice, LooksAtEachPointOnceOnAverage) {
  constexpr size_t kPointsOfGroup = 16;
  StageTile tile(floor_xml(rough_xml("roughplastic", 0.2)) + corner_xml(), 2, 4);
  tile.guess_visibility();
  const CellLight light = tile.light(3);
  const LocalPoints& points = light.local_points;
  ASSERT_FALSE(points.reflections.empty());
  const size_t count = points.points.size(), groups = count / kPointsOfGroup;
  std::vector<Moments> looks(groups);
  Moments all, weights;
  LocalChoice choice;
  constexpr uint64_t kSeeds = kHasSanitizer ? 100 : 2000;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    choice.choose(*light.local, points, tile.patches(), tile.visibility(), light.first_local(),
                  tile.primaries().size(), seed);
    std::vector<double> of_group(groups);
    double sum = 0;
    for (uint32_t b = 0; b < LocalChoice::kMinBlocks; ++b) {
      const LocalChoice::Block block = choice.block(b);
      for (uint32_t i = 0; i < block.size; ++i) {
        const double weight = block.weight[i] / LocalChoice::kMinBlocks;
        sum += weight;
        if (block.weight[i] > 0) weights.add(weight);
        const size_t group = block.point[i] / kPointsOfGroup;
        if (group < groups) of_group[group] += weight / kPointsOfGroup;
      }
    }
    all.add(sum / static_cast<double>(count));
    for (size_t g = 0; g < groups; ++g) looks[g].add(of_group[g]);
  }
  const auto expect_one = [](const Moments& moments, double alpha, const char* what, size_t index) {
    const double z = (moments.mean() - 1) / std::sqrt(moments.variance_of_mean());
    EXPECT_GT(normal_two_sided(z), alpha) << what << " " << index << ": " << moments.mean();
  };
  expect_one(all, kAlpha, "all points", 0);
  for (size_t g = 0; g < groups; ++g) expect_one(looks[g], kAlpha / groups, "group", g);
  EXPECT_GT(weights.variance_of_mean(), 0) << "all points have the same weight";
}

/// A block has the powers and eye ratios of its points, times the weight and divided by the rate of
/// the cell.
TEST(LocalChoice, BlocksWeighPowersByPointAndEyeRatiosByCell) {
  StageTile tile(floor_xml(kGrey) + corner_xml(), 2, 4);
  const CellLight light = tile.light(5);
  LocalChoice choice;
  choice.choose(*light.local, light.local_points, tile.patches(), tile.visibility(),
                light.first_local(), tile.primaries().size(), 1);
  const LocalChoice::Block block = choice.block(2);
  ASSERT_GT(block.size, 0u);
  for (uint32_t i = 0; i < block.size; ++i) {
    const LightPoint& point = light.local_points.points[block.point[i]];
    EXPECT_EQ(block.cell[i], point.cell);
    EXPECT_FLOAT_EQ(block.columns.power[1][i], point.power.y * block.weight[i]);
    if (block.weight[i] == 0) continue;
    EXPECT_FLOAT_EQ(block.columns.eye_ratio[i], point.eye_ratio / choice.rates()[point.cell]);
  }
}

/// Returns two points of one cell above a patch, at heights `near` and `far`.
LocalPoints two_points(float near, float far) {
  LocalPoints points;
  for (const float height : {near, far}) {
    LightPoint point;
    point.position = Vec3(0, 0, height);
    point.normal = point.geometric = Vec3(0, 0, -1);
    point.power = Rgb(1.f);
    points.points.push_back(point);
    points.reflection.push_back(point.reflection);
    points.group.push_back(point.group);
    points.rows.push_back({{0, 0, height}, {0, 0, -1}, {0, 0, -1}, {1, 1, 1}, 0});
  }
  points.first = {0, 2};
  return points;
}
constexpr simd::ReflectingPatch kFlat{{0, 0, 0}, {0, 0, 1}, {0, 0, 1}, 0.5f, 0, 1, 0, 1};

TEST(TriedPoints, PreferImportantPoints) {
  constexpr int kSeeds = 4000;
  constexpr double kRate = 0.5;
  const LocalPoints points = two_points(1, 10);
  const float visible = 1;
  int takes[2] = {};
  float weights[2] = {};
  TriedPoints tried;
  for (int seed = 0; seed < kSeeds; ++seed) {
    tried.begin(points);
    for (const uint32_t k : {0u, 1u}) tried.add(k, 0, 1, kRate, 1);
    tried.gather();
    tried.add_patch(kFlat, 0, &visible);
    std::vector<TriedPoints::Take> taken;
    tried.take(16, (seed + 0.5) / kSeeds, taken);
    for (const TriedPoints::Take& take : taken) {
      ++takes[take.point];
      weights[take.point] = take.weight;
    }
  }
  // Light decreases with the square of the distance. A quarter of the takes uses the rate.
  const double near = 0.75 * 100 / 101 + 0.25 * kRate, far = 0.75 / 101 + 0.25 * kRate;
  EXPECT_NEAR(takes[0], near * kSeeds, 1 + 1e-4 * kSeeds);
  EXPECT_NEAR(takes[1], far * kSeeds, 1 + 1e-4 * kSeeds);
  EXPECT_NEAR(weights[0], 1 / near, 1e-4);
  EXPECT_NEAR(weights[1], 1 / far, 1e-3);
  EXPECT_LE(weights[1], 4 / kRate) << "no weight exceeds four times that of the rate";
}

TEST(TriedPoints, TakeNoPointMoreThanOnceABlock) {
  const LocalPoints points = two_points(0.01f, 100);
  const float visible = 1;
  TriedPoints tried;
  tried.begin(points);
  for (const uint32_t k : {0u, 1u}) tried.add(k, 0, 1, 8, 1);
  tried.gather();
  tried.add_patch(kFlat, 0, &visible);
  std::vector<TriedPoints::Take> taken;
  tried.take(10, 0.5, taken);
  size_t of_near = 0;
  for (const TriedPoints::Take& take : taken) of_near += take.point == 0;
  EXPECT_EQ(of_near, 10u);
}

/// Patches that receive no light take points by their rates.
TEST(TriedPoints, TakeByRatesWhereNothingIsReflected) {
  const LocalPoints points = two_points(1, 2);
  const float visible = 1;
  simd::ReflectingPatch black = kFlat;
  black.diffuse = 0;
  TriedPoints tried;
  tried.begin(points);
  tried.add(0, 0, 0.5, 3, 1);
  tried.add(1, 0, 1, 2, 1);
  tried.gather();
  tried.add_patch(black, 0, &visible);
  std::vector<TriedPoints::Take> taken;
  tried.take(16, 0.5, taken);
  ASSERT_EQ(taken.size(), 8u);
  EXPECT_FLOAT_EQ(taken.front().weight, 1 / 3.f);
  EXPECT_FLOAT_EQ(taken.back().weight, 1 / 2.f);
}

}  // namespace
}  // namespace kinome::test::local_choice_test

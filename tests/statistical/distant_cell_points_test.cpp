#include <gtest/gtest.h>

#include <cmath>

#include "clustered/cells/light_cells.h"
#include "envmap_cases.h"
#include "kinome/clustered_light.h"
#include "kinome/warp.h"
#include "statistical/distant_cells.h"

/// Tests the points that DistantCells draws, and its limits.
namespace kinome::test::distant_cell_points_test {
namespace {

using namespace distant_cells;

constexpr double kAlpha = 1e-4;  // level of each statistical test

/// Compares the points of some draws with the density that look_up() returns on a grid over the
/// sphere.
TEST(DistantCells, PointsAreDrawnByTheirDensity) {
  constexpr int kRows = 60, kColumns = 120, kSteps = 5, kDraws = 12;
  for (const Case& c : cases()) {
    const DistantCells cells = make_cells(*c.emitter, 200);
    std::vector<double> share(cells.size());  // points of each cell
    std::vector<double> expected(kRows * kColumns), observed(kRows * kColumns);
    const glm::mat3 to_world = cell_grid_of(*c.emitter)->to_world;
    const auto bin = [&](const Vec3& d) {
      const Coordinates at = coordinates(glm::dvec3(cells.to_local(d)));
      return std::min(static_cast<int>((1 - std::cos(kPiD * at.v)) / 2 * kRows), kRows - 1) *
                 kColumns +
             std::min(static_cast<int>(at.u * kColumns), kColumns - 1);
    };
    for (int draw = 0; draw < kDraws; ++draw) {
      const CellPoints points = cells.draw_points(1 << 14, 100 + draw, scheduler());
      ASSERT_EQ(points.first.size(), cells.size() + 1u);
      Found found;
      for (const CellPoint& point : points.points) {
        observed[bin(point.d)] += 1;
        found.add(point.d);
      }
      for (uint32_t i = 0; i < cells.size(); ++i) {
        const uint32_t count = points.first[i + 1] - points.first[i];
        share[i] += count;
        EXPECT_EQ(points.pick(i, 0).cell, i);
        EXPECT_EQ(points.pick(i, 1 - 0x1p-24f).cell, i);
        EXPECT_EQ(count & (count - 1), 0u);
      }
      found.look_up(cells);
      size_t elsewhere = 0;
      for (size_t i = 0; i < points.points.size(); ++i) {
        const CellPoint& point = points.points[i];
        const bool same = found.cell[i] == point.cell &&
                          std::abs(found.density[i] - point.density) <= 1e-4f * point.density;
        elsewhere += !same;
        ASSERT_GT(point.density, 0) << c.name;
        const Rgb radiance = c.emitter->eval_environment(point.d);
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(point.weight[k] * point.density, radiance[k],
                      1e-4 * std::abs(radiance[k]) + 1e-3)
              << c.name;
        }
      }
      // Points within rounding of a quad's border may be found on its other side.
      EXPECT_LT(static_cast<double>(elsewhere), 1e-3 * static_cast<double>(points.points.size()))
          << c.name;
    }
    // Jittered positions in strips of equal solid angle. With midpoints, the borders of quads would
    // cause an error of 1 / kSteps of a bin.
    Found found;
    std::mt19937 rng(5);
    for (int y = 0; y < kRows * kSteps; ++y) {
      for (int x = 0; x < kColumns * kSteps; ++x) {
        const Vec2 u = random_pair(rng);
        const double cosine = 1 - 2 * (y + u.y) / (kRows * kSteps);
        found.add(to_world *
                  Vec3(direction((x + u.x) / (kColumns * kSteps), std::acos(cosine) / kPiD)));
      }
    }
    found.look_up(cells);
    double integral = 0, points = 0;
    for (size_t i = 0; i < found.x.size(); ++i) {
      const double angle = 4 * kPiD / static_cast<double>(found.x.size());
      expected[bin(found.direction(i))] += found.density[i] * angle * share[found.cell[i]];
      integral += found.density[i] * angle * share[found.cell[i]];
    }
    for (const double s : share) points += s;
    EXPECT_NEAR(integral / points, 1, 0.01) << c.name;  // the error of the jittered rule
    for (double& e : expected) e *= points / integral;
    // The points are stratified, so that the statistic is small unless a density is wrong. The
    // error of the rule, a few percent of a bin, is added to the variance of each bin's count.
    double statistic = 0;
    int bins = 0;
    for (size_t b = 0; b < expected.size(); ++b) {
      if (expected[b] < 5) continue;
      const double rule = 0.15 * expected[b];
      statistic += sqr(observed[b] - expected[b]) / (expected[b] + rule * rule);
      ++bins;
    }
    EXPECT_GE(chi2_tail(statistic, bins), kAlpha) << c.name << ": " << statistic << " of " << bins;
  }
}

/// If quads aren't smooth, the sums of the points replace the integrals of the cells.
TEST(DistantCells, SumsOfPointsAreTheCellsWhereQuadsAreNotSmooth) {
  const Disc disc;
  const DistantCells cells = make_cells(disc, 128);
  EXPECT_FALSE(cells.has_exact_flux());
  std::vector<Moments> sums(9);
  for (uint64_t seed = 0; seed < 24; ++seed) {
    const CellPoints points = cells.draw_points(1 << 14, seed, scheduler());
    for (int k = 0; k < 9; ++k) {
      double all = 0;
      for (uint32_t i = 0; i < cells.size(); ++i) {
        double sum = 0;
        for (uint32_t p = points.first[i]; p < points.first[i + 1]; ++p) {
          sum += points.points[p].weight[k / 3] * points.points[p].d[k % 3];
        }
        sum /= points.first[i + 1] - points.first[i];
        EXPECT_NEAR(points.vector_flux[k][i], sum, 1e-5 * std::abs(sum) + 1e-6);
        all += sum;
      }
      sums[k].add(all);
    }
  }
  // The disc contributes its radiance minus the sky's behind it, times its axis, to 2e-4 (cos
  // 0.02). The gradient a (1.2 + d.y) contributes 4 pi / 3 a along y.
  const Vec3 centre = glm::normalize(Vec3(0.4f, 0.7f, -0.5f));
  const double angle = 2 * kPiD * (1 - std::cos(0.02));
  const double sky[3] = {0.2, 0.3, 0.5}, sun[3] = {800, 600, 300};
  std::vector<Estimate> measured, exact;
  for (int k = 0; k < 9; ++k) {
    const int c = k / 3, axis = k % 3;
    const double value =
        angle * (1 + std::cos(0.02)) / 2 * centre[axis] * (sun[c] - sky[c] * (1.2 + centre.y)) +
        (axis == 1 ? 4 * kPiD / 3 * sky[c] : 0);
    exact.push_back({value, sqr(2e-4 * value)});
    measured.push_back({sums[k].mean(), sums[k].variance_of_mean()});
  }
  const Verdict verdict = z_test(measured, exact, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

TEST(DistantCells, BlackLightHasNone) {
  const auto map = envmap({"black", 8, 5, [](int, int) { return Rgb(0.f); }});
  EXPECT_EQ(make_cells(*map, 512).size(), 0u);
  const auto constant =
      make<Emitter>("<emitter type=\"constant\"><rgb name=\"radiance\" value=\"0\"/></emitter>");
  EXPECT_EQ(make_cells(*constant, 512).size(), 0u);
}

/// Requests more cells than there are quads, and more than an index can number.
TEST(DistantCells, AreLimitedByQuadsAndIndices) {
  Disc disc;  // has 256 x 128 quads
  EXPECT_EQ(make_cells(disc, 100000).size(), kMaxCells);
  const auto small = envmap(maps()[0]);
  const EnvironmentGrid grid = cell_grid_of(*small).value();
  const uint32_t quads = std::max(grid.columns, 32) * std::max(grid.rows, 16);
  EXPECT_LE(make_cells(*small, 100000).size(), 4 * quads);
  const CellPoints points = make_cells(disc, 100000).draw_points(1 << 15, 1, scheduler());
  EXPECT_LE(points.points.size(), 6u * kMaxCells);
  for (uint32_t c = 0; c < kMaxCells; ++c) EXPECT_GE(points.first[c + 1] - points.first[c], 4u);
}

TEST(DistantCells, SameSeedSamePoints) {
  const auto map = envmap(maps()[1]);
  const auto draw = [&](unsigned threads, uint64_t seed) {
    const RenderContext own({.threads = threads});
    const DistantCells cells(*map, *cell_grid_of(*map), 64, own.scheduler);
    std::vector<float> values;
    for (const CellPoint& p : cells.draw_points(1 << 12, seed, own.scheduler).points) {
      values.insert(values.end(), {p.d.x, p.d.y, p.d.z, p.weight.x, p.density});
    }
    return values;
  };
  EXPECT_EQ(draw(1, 4), draw(3, 4));
  EXPECT_NE(draw(1, 4), draw(1, 5));
}

}  // namespace
}  // namespace kinome::test::distant_cell_points_test

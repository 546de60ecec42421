// Tests of cells of distant light: they partition the sphere, their integrals are correct, and
// their points have the density that look_up() returns.
#include <gtest/gtest.h>

#include <cmath>

#include "clustered/cells/light_cells.h"
#include "envmap_cases.h"
#include "kinome/clustered_light.h"
#include "kinome/warp.h"

namespace kinome::test::distant_cells_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each statistical test

/// An emitter that implements only the mandatory functions, as a third party's may: a disc far
/// smaller than a quad, on a gradient.
class Disc final : public Emitter, public ClusteredLight {
 public:
  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    const Vec3 centre = glm::normalize(Vec3(0.4f, 0.7f, -0.5f));
    return glm::dot(d, centre) > std::cos(0.02f) ? Rgb(800, 600, 300)
                                                 : Rgb(0.2f, 0.3f, 0.5f) * (1.2f + d.y);
  }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2& u) const override {
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    sample.pdf = kUniformSpherePdf;
    sample.radiance = eval_environment(sample.d);
    return sample;
  }
  float pdf_environment(const Vec3&) const override { return kUniformSpherePdf; }
  std::optional<EnvironmentGrid> cell_grid() const override { return EnvironmentGrid{}; }
};

struct Case {
  std::string name;
  std::shared_ptr<Emitter> emitter;
  bool black = false;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Map& map : maps()) all.push_back({map.name, envmap(map)});
  all.push_back({"noise, rotated", envmap(maps()[0], kRotation)});
  all.push_back({"sun at the pole, mirrored",
                 envmap(maps()[1], "<transform name=\"to_world\"><scale x=\"-1\"/></transform>")});
  all.push_back({"constant", make<Emitter>("<emitter type=\"constant\"><rgb name=\"radiance\" "
                                           "value=\"1 .5 .25\"/></emitter>")});
  all.push_back({"disc", std::make_shared<Disc>()});
  all.push_back({"sunsky", make<Emitter>("<emitter type=\"sunsky\"><vector name=\"sun_direction\" "
                                         "value=\"1 1 1\"/><float name=\"sun_aperture\" "
                                         "value=\"30\"/></emitter>")});
  return all;
}

const Scheduler& scheduler() {
  static const RenderContext instance({.threads = 2});
  return instance.scheduler;
}
DistantCells make_cells(const Emitter& emitter, uint32_t count) {
  return {emitter, cell_grid_of(emitter).value(), count, scheduler()};
}

/// A cell's rectangle in its own space, computed from its edges.
struct Rectangle {
  double phi0, width, theta0, theta1;
  bool contains(const glm::dvec3& d, double slack) const {
    const double theta = std::atan2(std::hypot(d.x, d.z), d.y), sine = std::sin(theta);
    if (theta < theta0 - slack || theta > theta1 + slack) return false;
    double phi = std::fmod(std::atan2(d.x, -d.z) - phi0 + 4 * kPiD, 2 * kPiD);
    if (phi > kPiD + width / 2) phi -= 2 * kPiD;
    return phi * sine > -slack && (phi - width) * sine < slack;
  }
  double solid_angle() const { return width * (std::cos(theta0) - std::cos(theta1)); }
};
Rectangle rectangle(const DistantCells& cells, uint32_t cell) {
  const auto edge = [&](int k) { return static_cast<double>(cells.edges()[k][cell]); };
  Rectangle r{};
  r.phi0 = std::atan2(edge(0), edge(1));
  r.width = std::atan2(edge(2), edge(3)) - r.phi0;
  if (r.width <= 0) r.width += 2 * kPiD;
  r.theta0 = std::atan2(edge(5), edge(4));
  r.theta1 = std::atan2(edge(7), edge(6));
  return r;
}

/// Directions and the results of look_up() for them.
struct Found {
  std::vector<float> x, y, z, density;
  std::vector<uint32_t> cell;
  std::vector<Rgb> radiance;
  void add(const Vec3& d) {
    x.push_back(d.x);
    y.push_back(d.y);
    z.push_back(d.z);
  }
  Vec3 direction(size_t i) const { return {x[i], y[i], z[i]}; }
  void look_up(const DistantCells& cells) {
    const size_t count = x.size();
    while (x.size() % DistantCells::kPadding != 0) add(Vec3(0, 1, 0));
    density.resize(x.size());
    cell.resize(x.size());
    radiance.resize(x.size());
    cells.look_up({x.data(), y.data(), z.data(), cell.data(), density.data(), radiance.data()},
                  count);
    x.resize(count);
  }
};

/// Calls f with `count` uniformly distributed random directions.
template <class Function>
void for_directions(std::mt19937& rng, int count, const Function& f) {
  for (int i = 0; i < count; ++i) f(square_to_uniform_sphere(random_pair(rng)));
}

TEST(DistantCells, PartTheSphere) {
  for (const Case& c : cases()) {
    for (const uint32_t count : {1u, 2u, 30u, 512u, 100000u}) {
      const DistantCells cells = make_cells(*c.emitter, count);
      ASSERT_GT(cells.size(), 0u) << c.name;
      EXPECT_LE(cells.size(), std::max(count, 48u)) << c.name;
      EXPECT_LE(cells.size(), kMaxCells);
      EXPECT_EQ(cells.padded_size() % DistantCells::kPadding, 0u);
      std::vector<Rectangle> rectangles;
      double total = 0;
      for (uint32_t i = 0; i < cells.size(); ++i) {
        rectangles.push_back(rectangle(cells, i));
        total += rectangles.back().solid_angle();
        EXPECT_LT(rectangles.back().width, kPiD / 2) << c.name;
        EXPECT_GT(cells.flux()[i], 0) << c.name;
      }
      EXPECT_NEAR(total, 4 * kPiD, 1e-4) << c.name << ", " << count;
      for (uint32_t i = cells.size(); i < cells.padded_size(); ++i) EXPECT_EQ(cells.flux()[i], 0);
      if (count > 1000) continue;
      std::mt19937 rng(3);
      Found found;
      for_directions(rng, 400, [&](const Vec3& d) { found.add(d); });
      found.look_up(cells);
      for (size_t i = 0; i < found.x.size(); ++i) {
        const glm::dvec3 local(cells.to_local(found.direction(i)));
        ASSERT_LT(found.cell[i], cells.size());
        EXPECT_TRUE(rectangles[found.cell[i]].contains(local, 1e-5)) << c.name << ", " << count;
        int others = 0;
        for (const Rectangle& r : rectangles) others += r.contains(local, -1e-5);
        EXPECT_LE(others, 1) << c.name;
      }
    }
  }
}

/// Tests the seam, the poles and the axes, where coordinates may round to the other end.
TEST(DistantCells, LookUpStandsAnyDirection) {
  for (const Case& c : cases()) {
    const DistantCells cells = make_cells(*c.emitter, 64);
    const glm::mat3 to_world = cell_grid_of(*c.emitter)->to_world;
    Found found;
    for (const float tiny : {0.f, 1e-30f, 1e-10f, 1e-7f, 1e-5f}) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int signs = 0; signs < 8; ++signs) {
          Vec3 d(signs & 1 ? tiny : -tiny, signs & 2 ? tiny : -tiny, signs & 4 ? tiny : -tiny);
          d[axis] = signs >> axis & 1 ? 1.f : -1.f;
          found.add(to_world * glm::normalize(d));
        }
      }
    }
    for (int column = 0; column <= 16; ++column) {  // both sides of column borders
      for (const double step : {-1e-7, -1e-8, 0., 1e-8, 1e-7}) {
        found.add(to_world * Vec3(direction(column / 16. + step, 0.4)));
        found.add(to_world * Vec3(direction((column + 0.5) / 16. + step, 0.4)));
      }
    }
    found.look_up(cells);
    for (size_t i = 0; i < found.x.size(); ++i) {
      ASSERT_LT(found.cell[i], cells.size()) << c.name;
      EXPECT_GT(found.density[i], 0) << c.name;
      EXPECT_TRUE(std::isfinite(found.density[i])) << c.name;
      // At a pole any longitude is valid.
      const Vec3 local = cells.to_local(found.direction(i));
      if (std::hypot(local.x, local.z) < 1e-4f) continue;
      const Rgb expected = c.emitter->eval_environment(found.direction(i));
      for (int k = 0; k < 3; ++k) {
        // Coordinates have an error of 1e-6 texels. Maps change by at most 2000 per texel, or by
        // their whole range.
        EXPECT_NEAR(found.radiance[i][k], expected[k],
                    2e-4 * std::abs(expected[k]) + (c.name == "huge range" ? 1e8 : 0.2))
            << c.name << " " << found.x[i] << " " << found.y[i] << " " << found.z[i];
      }
    }
  }
}

/// Compares describe() with sums over a fine grid within each cell, in doubles.
TEST(DistantCells, IntegralsAreThoseOfTheirLight) {
  for (const Case& c : cases()) {
    const DistantCells cells = make_cells(*c.emitter, 100);
    if (!cells.has_exact_flux()) continue;
    const glm::mat3 to_world = cell_grid_of(*c.emitter)->to_world;
    for (uint32_t i = 0; i < cells.size(); ++i) {
      const Rectangle r = rectangle(cells, i);
      // The grid's lines include those of the quads: a quad is at most pi / 16, or half a row of a
      // map.
      const int columns = 64 * std::max(1, static_cast<int>(std::lround(r.width * 16 / kPiD)));
      const int rows = 64;
      double flux[9] = {}, magnitude[9] = {}, scalar = 0;
      for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
          if (columns > 128 && (x + y) % 4 != 0) continue;
          const double phi = r.phi0 + r.width * (x + 0.5) / columns;
          const double theta = r.theta0 + (r.theta1 - r.theta0) * (y + 0.5) / rows;
          const Vec3 d = to_world * Vec3(direction(phi / (2 * kPiD), theta / kPiD));
          const Rgb l = c.emitter->eval_environment(d);
          const double w = std::sin(theta) * (r.theta1 - r.theta0) / rows * r.width / columns *
                           (columns > 128 ? 4 : 1);
          scalar += w * std::abs(l.x + l.y + l.z) / 3;
          for (int k = 0; k < 9; ++k) {
            flux[k] += w * l[k / 3] * d[k % 3];
            magnitude[k] += w * std::abs(l[k / 3]);
          }
        }
      }
      for (int k = 0; k < 9; ++k) {
        EXPECT_NEAR(cells.vector_flux()[k][i], flux[k], 2e-3 * magnitude[k] + 1e-30)
            << c.name << ", cell " << i << ", " << k;
      }
      // The flux is only an importance here: quads count with the value at their centres.
      if (c.name != "negative texels" && c.name != "huge range") {
        EXPECT_GT(cells.flux()[i], 0.5 * scalar) << c.name;
        EXPECT_LT(cells.flux()[i], 2 * scalar + 0.01) << c.name;
      }
      for (int s = 0; s <= 8; ++s) {
        for (int t = 0; t <= 8; ++t) {
          const double phi = r.phi0 + r.width * s / 8,
                       theta = r.theta0 + (r.theta1 - r.theta0) * t / 8;
          const Vec3 d = to_world * Vec3(direction(phi / (2 * kPiD), theta / kPiD));
          const Vec3 axis(cells.axis()[0][i], cells.axis()[1][i], cells.axis()[2][i]);
          EXPECT_LE(std::acos(std::min(1.f, glm::dot(axis, d))), cells.radius()[i] + 1e-2f);
        }
      }
    }
  }
}

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
TEST(DistantCells, AreNoMoreThanThereCanBe) {
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
}  // namespace kinome::test::distant_cells_test

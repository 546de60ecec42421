// Tests of cells of distant light: they partition the sphere, their integrals are correct, and
// their points have the density that look_up() returns.
#include <gtest/gtest.h>

#include <cmath>

#include "clustered/cells/light_cells.h"
#include "envmap_cases.h"
#include "kinome/clustered_light.h"
#include "kinome/warp.h"
#include "statistical/distant_cells.h"

namespace kinome::test::distant_cells_test {
namespace {

using namespace distant_cells;

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
TEST(DistantCells, LookUpAcceptsAnyDirection) {
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
TEST(DistantCells, IntegralsMatchTheirLight) {
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

}  // namespace
}  // namespace kinome::test::distant_cells_test

// Kernels of learned product sampling against plain code in double precision, on the instruction
// set of this machine and on the scalar one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <tuple>

#include "cell_kernels.h"
#include "instruction_sets.h"
#include "kinome/light_cut.h"
#include "kinome/warp.h"
#include "lobe_kernels.h"
#include "support/statistics.h"

namespace kinome::test {
namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr double kAlpha = 1e-4;  // of each statistical test

/// Runs `test` with the kernels of each instruction set that this machine has.
void with_all_kernels(const std::function<void()>& test) {
  for_each_instruction_set(test);
}

class Random {
 public:
  explicit Random(unsigned seed) : rng_(seed) {}
  float unit() { return static_cast<float>(rng_() >> 8) * 0x1p-24f; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  Vec3 direction() { return square_to_uniform_sphere({unit(), unit()}); }

 private:
  std::mt19937 rng_;
};

/// Rectangles in longitude and latitude, with what their light is, as DistantCells has them.
struct Cells {
  struct Rectangle {
    double phi0, phi1, theta0, theta1;
    glm::dvec3 direction(double s, double t) const {
      const double phi = phi0 + (phi1 - phi0) * s, theta = theta0 + (theta1 - theta0) * t;
      return {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
    }
  };
  std::vector<Rectangle> rectangles;
  std::vector<float> edges[8], axis[3], radius, flux, importance[3], vector_flux[9];
  std::vector<float> v, sigma, sigma_mixed, transmittance;

  Cells(size_t count, unsigned seed) {
    Random random(seed);
    const size_t padded = simd::pad_lanes(count);
    for (auto* const columns : {&radius, &flux, &v, &sigma, &sigma_mixed, &transmittance}) {
      columns->resize(padded);
    }
    for (auto& c : edges) c.resize(padded);
    for (auto& c : axis) c.resize(padded);
    for (auto& c : importance) c.resize(padded);
    for (auto& c : vector_flux) c.resize(padded);
    for (size_t i = 0; i < count; ++i) {
      Rectangle r{};
      r.phi0 = random.between(0, 2 * kPiD);
      // From a fraction of a degree to half a turn, and caps around the poles.
      r.phi1 = r.phi0 + kPiD * std::pow(10, random.between(-3, 0));
      r.theta0 = i % 9 == 0 ? 0 : random.between(0, kPiD);
      r.theta1 = i % 9 == 1 ? kPiD : std::min(kPiD, r.theta0 + std::pow(10, random.between(-3, 0)));
      rectangles.push_back(r);
      const double values[8] = {std::sin(r.phi0),   std::cos(r.phi0),   std::sin(r.phi1),
                                std::cos(r.phi1),   std::cos(r.theta0), std::sin(r.theta0),
                                std::cos(r.theta1), std::sin(r.theta1)};
      for (int k = 0; k < 8; ++k) edges[k][i] = static_cast<float>(values[k]);
      const Vec3 centre(r.direction(0.5, 0.5));
      flux[i] = i % 17 == 5 ? 0.f : std::pow(10.f, 4 * random.unit() - 2);
      radius[i] = 0.3f * random.unit();
      for (int k = 0; k < 3; ++k) {
        axis[k][i] = centre[k];
        importance[k][i] = centre[k] * flux[i] * 0.9f;
        for (int c = 0; c < 3; ++c) {
          vector_flux[c * 3 + k][i] = flux[i] * (centre[k] + 0.1f * random.unit());
        }
      }
      v[i] = random.unit();
      sigma[i] = 0.01f + random.unit();
      sigma_mixed[i] = 0.1f + random.unit();
      transmittance[i] = 0.5f + random.unit();
    }
  }
  simd::CellColumns columns() const {
    simd::CellColumns c;
    c.count = flux.size();
    for (int k = 0; k < 8; ++k) c.edges[k] = edges[k].data();
    for (int k = 0; k < 3; ++k) {
      c.axis[k] = axis[k].data();
      c.importance_flux[k] = importance[k].data();
    }
    for (int k = 0; k < 9; ++k) c.vector_flux[k] = vector_flux[k].data();
    c.radius = radius.data();
    c.flux = flux.data();
    return c;
  }
  simd::CellKnowledge knowledge() const { return {v.data(), sigma.data(), sigma_mixed.data()}; }

  struct Range {
    double low = 2, high = -2;
  };
  /// By dense sampling: of at most pi x 1 rad, 48 steps miss an extreme by less than 1e-3 / 2.
  Range cosines(size_t cell, const glm::dvec3& n) const {
    constexpr int kSteps = 48;
    Range range;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        const double c =
            glm::dot(n, rectangles[cell].direction(i / double{kSteps}, j / double{kSteps}));
        range.low = std::min(range.low, c);
        range.high = std::max(range.high, c);
      }
    }
    return range;
  }
};

enum Side { kBelow, kMixed, kAbove };
std::vector<Side> sides_of(const simd::PatchCells& patch, const Cells& cells) {
  std::vector<Side> sides(cells.flux.size(), kBelow);
  for (size_t i = 0; i < patch.above + patch.mixed; ++i) {
    const uint32_t id = patch.ids()[i];
    const bool above = i < patch.above;
    const float flux = above ? patch.above_column(simd::PatchCells::kLeast)[i]
                             : patch.mixed_column(simd::PatchCells::kFlux)[i - patch.above];
    if (!(flux > 0)) continue;  // padding
    EXPECT_EQ(sides.at(id), kBelow) << id << " is listed twice";
    sides.at(id) = above ? kAbove : kMixed;
  }
  return sides;
}

/// Every sampled direction of a cell `above` is above the horizon of every normal of the cone, of
/// those `below` none, within the rounding of floats; and cells are mixed only where that is so.
TEST(CellKernels, SortCellsByTheirWholeRectangles) {
  const Cells cells(250, 1);
  with_all_kernels([&] {
    Random random(2);
    int counts[3] = {};
    for (int trial = 0; trial < 40; ++trial) {
      Vec3 n = random.direction();
      if (trial < 6) {
        n = Vec3(0.f);
        n[trial % 3] = trial < 3 ? 1.f : -1.f;
      }
      const double sine = trial % 4 == 0 ? 0 : std::pow(10, random.between(-3, 0));
      simd::PatchCells patch;
      simd::classify_cells(cells.columns(), &n.x, static_cast<float>(sine), cells.knowledge(),
                           nullptr, patch);
      const auto sides = sides_of(patch, cells);
      for (size_t i = 0; i < cells.rectangles.size(); ++i) {
        if (cells.flux[i] == 0) {
          EXPECT_EQ(sides[i], kBelow);
          continue;
        }
        const Cells::Range range = cells.cosines(i, glm::dvec3(n));
        ++counts[sides[i]];
        EXPECT_TRUE(sides[i] != kAbove || range.low >= sine - 1e-5) << i << ": " << range.low;
        EXPECT_TRUE(sides[i] != kBelow || range.high <= -sine + 1e-5) << i << ": " << range.high;
        if (sides[i] == kMixed) {
          EXPECT_LE(range.low, sine + 1e-3);
          EXPECT_GE(range.high, -sine - 1e-3);
        }
      }
    }
    for (const int count : counts) EXPECT_GT(count, 500);
  });
}

/// A cone of more than a right angle: nothing is known to be above or below.
TEST(CellKernels, WidestConesKeepAllCells) {
  const Cells cells(100, 4);
  with_all_kernels([&] {
    const Vec3 n(0, 1, 0);
    simd::PatchCells patch;
    simd::classify_cells(cells.columns(), &n.x, 2, cells.knowledge(), nullptr, patch);
    const auto sides = sides_of(patch, cells);
    for (size_t i = 0; i < cells.rectangles.size(); ++i) {
      EXPECT_EQ(sides[i], cells.flux[i] > 0 ? kMixed : kBelow);
    }
  });
}

/// Weights, visibilities and control of strata, cell by cell in doubles.
TEST(CellKernels, DiffuseStrataAreWhatTheySum) {
  const Cells cells(300, 7);
  with_all_kernels([&] {
    Random random(8);
    simd::PatchCells patch;
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3 mean = random.direction();
      const Vec3 n = glm::normalize(mean + 0.1f * random.direction());
      const float* const t = trial % 2 ? cells.transmittance.data() : nullptr;
      const auto factor = [&](size_t id) { return t ? static_cast<double>(t[id]) : 1.; };
      // The cone of the patch holds that of the group.
      simd::classify_cells(cells.columns(), &mean.x, 0.15f, cells.knowledge(), t, patch);
      const simd::GroupNormal normal{{n.x, n.y, n.z}, {n.x, n.y, n.z}, 0.02f};
      const float scale = 0.3f;
      const size_t size = patch.above + patch.mixed;
      std::vector<float> p(size), sums(size / simd::kCellLanes), visibility(patch.mixed);
      float control[9];
      const float total = simd::diffuse_strata(patch, normal, scale, p.data(), sums.data(),
                                               visibility.data(), control);
      double expected_control[9] = {}, magnitude[9] = {}, expected_total = 0;
      for (size_t i = 0; i < size; ++i) {
        const size_t id = patch.ids()[i];
        const bool listed_above = i < patch.above;
        const float lit = listed_above
                              ? patch.above_column(simd::PatchCells::kLeast)[i]
                              : patch.mixed_column(simd::PatchCells::kFlux)[i - patch.above];
        if (!(lit > 0)) {
          EXPECT_EQ(p[i], 0);
          continue;
        }
        const double flux = cells.flux[id];
        double towards = 0;
        for (int k = 0; k < 3; ++k) towards += static_cast<double>(n[k]) * cells.importance[k][id];
        const Cells::Range range = cells.cosines(id, glm::dvec3(n));
        double expected = 0, v = cells.v[id] * factor(id);
        double slack = 1e-5 * flux * scale * factor(id);
        if (listed_above || visibility[i - patch.above] > 0) {
          expected = std::max(towards, 1e-3 * flux) * cells.sigma[id];
          EXPECT_GE(range.low, 0.02 - 1e-5) << id;
          EXPECT_TRUE(listed_above || std::abs(visibility[i - patch.above] - v) < 1e-6) << id;
        } else {
          v = 0;
          const double highest = std::max(range.high, 0.02);
          if (range.high > -0.02 + 1e-3) {
            expected = std::max(towards, 0.4 * flux * highest) * cells.sigma_mixed[id];
            slack += 1e-3 * flux * scale * factor(id);  // of the sampled extremes
            EXPECT_LE(range.low, 0.02 + 1e-3);
          } else if (range.high > -0.02 - 1e-3) {
            expected = p[i] / (scale * factor(id));  // too near to tell
          }
        }
        expected *= scale * factor(id);
        EXPECT_NEAR(p[i], expected, 1e-5 * expected + slack) << id;
        EXPECT_TRUE(range.high <= 0 || p[i] > 0) << id << ": light without a ray";
        expected_total += p[i];
        for (int k = 0; k < 9; ++k) {
          expected_control[k] += v * cells.vector_flux[k][id];
          magnitude[k] += v * std::abs(cells.vector_flux[k][id]);
        }
      }
      double blocks = 0;
      for (const float s : sums) blocks += s;
      EXPECT_NEAR(total, expected_total, 1e-5 * expected_total);
      EXPECT_NEAR(blocks, expected_total, 1e-5 * expected_total);
      for (int k = 0; k < 9; ++k) EXPECT_NEAR(control[k], expected_control[k], 1e-5 * magnitude[k]);
    }
  });
}

TEST(CellKernels, GlossyImportanceIsTheWidenedLobe) {
  const Cells cells(300, 11);
  with_all_kernels([&] {
    Random random(12);
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3 n = random.direction();
      Vec3 viewer = random.direction();
      if (glm::dot(viewer, n) < 0) viewer = -viewer;
      const simd::GlossyQuery query{{n.x, n.y, n.z},
                                    {viewer.x, viewer.y, viewer.z},
                                    std::pow(10.f, -4 * random.unit()),
                                    trial % 3 ? 0.1f * random.unit() : 0.f};
      std::vector<float> importance(cells.flux.size());
      std::vector<float> sums(cells.flux.size() / simd::kCellLanes);
      const float total =
          simd::glossy_importance(cells.columns(), query, importance.data(), sums.data());
      double expected_total = 0;
      for (size_t i = 0; i < cells.flux.size(); ++i) {
        const glm::dvec3 c(cells.axis[0][i], cells.axis[1][i], cells.axis[2][i]);
        const glm::dvec3 h = glm::dvec3(viewer) + c;
        const double radius = cells.radius[i], nh = glm::dot(glm::dvec3(n), h);
        const double cosine2 = std::max(1e-4, nh * nh / std::max(glm::dot(h, h), 1e-12));
        const double a2 = std::min(1., double{query.alpha2} + query.spread + radius * radius / 8);
        const double denominator = 1 - cosine2 * (1 - a2);
        const double above = glm::dot(glm::dvec3(n), c) + radius + 2 * std::sqrt(query.spread);
        const double lobe = a2 / (denominator * denominator);
        expected_total += importance[i];
        if (cells.flux[i] == 0 || above < 1e-6) {
          EXPECT_TRUE(importance[i] == 0 || above > -1e-6);
          continue;
        }
        // 1 - cosine2 cancels: 4 units of 2^-24 on a denominator of a2 at least.
        EXPECT_NEAR(importance[i], cells.flux[i] * lobe,
                    cells.flux[i] * lobe * (1e-5 + 5e-7 / denominator));
      }
      EXPECT_NEAR(total, expected_total, 1e-5 * expected_total);
    }
  });
}

TEST(CellKernels, BlocksAreSummed) {
  with_all_kernels([] {
    Random random(3);
    std::vector<float> values(80), sums(5);
    double expected[5] = {};
    for (size_t i = 0; i < values.size(); ++i) expected[i / 16] += values[i] = random.unit();
    double total = 0;
    for (const double e : expected) total += e;
    EXPECT_NEAR(simd::sum_blocks(values.data(), values.size(), sums.data()), total, 1e-5 * total);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(sums[i], expected[i], 1e-6 * expected[i]);
  });
}

/// One point, and directions of its lobe one by one.
class Lobe {
 public:
  Lobe(float alpha_u, float alpha_v, const Vec3& normal, float viewer_cosine)
      : lobe_{alpha_u, alpha_v}, n_(normal) {
    const Frame frame = Frame::from_normal(normal);
    t_ = frame.s;
    w_ = viewer_cosine * n_ +
         std::sqrt(1 - sqr(viewer_cosine)) * glm::normalize(frame.s + 0.5f * frame.t);
    frames_.resize(1);
    for (int axis = 0; axis < 3; ++axis) {
      frames_.normal[axis][0] = n_[axis];
      frames_.tangent[axis][0] = t_[axis];
      frames_.viewer[axis][0] = w_[axis];
    }
  }
  Vec3 sample(const Vec2& u) const {
    uint32_t u1[simd::kLobeLanes], u2[simd::kLobeLanes];
    std::fill(u1, u1 + simd::kLobeLanes, static_cast<uint32_t>(u.x * 0x1p32));
    std::fill(u2, u2 + simd::kLobeLanes, static_cast<uint32_t>(u.y * 0x1p32) ^ kShift);
    float x[simd::kLobeLanes], y[simd::kLobeLanes], z[simd::kLobeLanes];
    simd::sample_lobe(lobe_, group_, members_, {u1, u2, {0, kShift}}, simd::kLobeLanes, x, y, z);
    return {x[0], y[0], z[0]};
  }
  float density(const Vec3& d) const {
    float x[simd::kLobeLanes], y[simd::kLobeLanes], z[simd::kLobeLanes];
    std::fill(x, x + simd::kLobeLanes, d.x);
    std::fill(y, y + simd::kLobeLanes, d.y);
    std::fill(z, z + simd::kLobeLanes, d.z);
    float density[simd::kLobeLanes];
    simd::lobe_density(lobe_, group_, members_, x, y, z, simd::kLobeLanes, density);
    return density[0];
  }
  /// As of the half vector that the random numbers stand for, in doubles; 0: behind it.
  double exact_density(const Vec2& u) const {
    const double r = std::sqrt(u.x / (1. - u.x)), phi = 2 * kPiD * u.y;
    const double hu = lobe_.alpha_u * r * std::cos(phi), hv = lobe_.alpha_v * r * std::sin(phi);
    const glm::dvec3 n(n_), t(t_), b = glm::cross(n, t);
    const glm::dvec3 h = glm::normalize(n + hu * t + hv * b);
    const double cosine = glm::dot(h, n), wh = glm::dot(glm::dvec3(w_), h);
    if (wh <= 0) return 0;
    const double q = 1 + r * r;  // (hu / au)² + (hv / av)² + 1, of slopes
    const double c4 = cosine * cosine * cosine * cosine;
    return cosine / (kPiD * lobe_.alpha_u * lobe_.alpha_v * q * q * c4) / (4 * wh);
  }
  const Vec3& normal() const { return n_; }
  const Vec3& viewer() const { return w_; }

 private:
  simd::HalfVectorLobe lobe_;
  simd::PointFrames frames_;
  static constexpr uint32_t kShift = 0x5bd1e995u;
  const uint32_t members_[simd::kLobeLanes] = {};
  const simd::PointGroup group_{frames_, members_, 1};
  Vec3 n_, t_, w_;
};

const Vec3 kNormal = glm::normalize(Vec3(0.3f, -0.5f, 0.8f));

/// On vectors; scalar code has the same densities, and directions of these, by the next test.
TEST(LobeKernels, DirectionsHaveTheirDensity) {
  for (const auto& [u, v] : {std::pair(0.2f, 0.2f), {0.15f, 0.6f}, {1.f, 1.f}}) {
    for (const float cosine : {0.95f, 0.3f}) {
      const Lobe lobe(u, v, kNormal, cosine);
      // Half vectors from behind mirror to where nothing is reflected.
      const auto sample = [&](float, const Vec2& random) -> std::optional<Vec3> {
        const Vec3 d = lobe.sample(random);
        EXPECT_NEAR(glm::dot(d, d), 1, 1e-5);
        if (glm::dot(lobe.viewer() + d, lobe.normal()) <= 0) return std::nullopt;
        return d;
      };
      const auto density = [&](const Vec3& d) { return lobe.density(d); };
      const Verdict verdict = sphere_chi2_test({sample, density, 200000, 16, 16}, kAlpha);
      EXPECT_TRUE(verdict.passed) << u << ", " << v << ", " << cosine << ": " << verdict.text;
      const Verdict jacobian =
          jacobian_test([&](const Vec2& random) { return sample(0, random); }, density, 2000, 2e-3);
      EXPECT_TRUE(jacobian.passed) << u << ", " << v << ", " << cosine << ": " << jacobian.text;
    }
  }
}

/// Estimates divide by the density: where it is wrong by rounding, they are biased by the mean of
/// true / computed.
TEST(LobeKernels, DensitiesOfSharpLobesAreExact) {
  with_all_kernels([] {
    for (const float alpha : {0.0002f, 0.001f, 0.003f, 0.01f, 0.05f, 0.3f}) {
      for (const float cosine : {0.95f, 0.2f}) {
        const Lobe lobe(alpha, alpha, kNormal, cosine);
        Random random(5);
        Moments ratio;
        for (int i = 0; i < 4000; ++i) {
          const Vec2 u(random.unit(), random.unit());
          const double exact = lobe.exact_density(u);
          const double computed = lobe.density(lobe.sample(u));
          if (!(exact > 0) || u.x > 0.9999f) continue;
          if (!(computed > 0)) {
            EXPECT_LT(exact, 1e-6);
            continue;
          }
          ratio.add(exact / computed);
        }
        EXPECT_NEAR(ratio.mean(), 1, 1e-3) << alpha << ", " << cosine;
      }
    }
  });
}

TEST(LobeKernels, ExtremesAreFinite) {
  with_all_kernels([] {
    for (const float alpha : {2e-4f, 1.f}) {
      const Lobe lobe(alpha, alpha, kNormal, 0.01f);
      for (const float u1 : {0.f, 0.5f, 1 - 0x1p-24f}) {
        for (const float u2 : {0.f, 0.125f, 0.25f, 0.375f, 0.5f, 0.75f, 0.875f, 1 - 0x1p-24f}) {
          const Vec3 d = lobe.sample({u1, u2});
          EXPECT_NEAR(glm::dot(d, d), 1, 1e-5);
          EXPECT_GE(lobe.density(d), 0);
          EXPECT_TRUE(std::isfinite(lobe.density(d)));
        }
      }
      for (const Vec3& d : {lobe.viewer(), -lobe.viewer(), lobe.normal(), -lobe.normal()}) {
        EXPECT_GE(lobe.density(d), 0);
        EXPECT_TRUE(std::isfinite(lobe.density(d)));
      }
    }
  });
}

/// Places on a grid of directions everywhere, on the axes, and beside them.
TEST(LobeKernels, PlacesAreThoseOfTheLibrary) {
  with_all_kernels([] {
    Random random(9);
    const Frame frame = Frame::from_normal(kNormal);
    const glm::mat3 worlds[2] = {glm::mat3(1.f), glm::mat3(frame.s, frame.t, kNormal)};
    std::vector<Vec3> directions;
    for (int axis = 0; axis < 3; ++axis) {
      for (const float sign : {1.f, -1.f}) {
        for (const float tiny : {0.f, 1e-3f, 1e-7f, -1e-7f, -1e-30f}) {
          Vec3 d(tiny);
          d[axis] = sign;
          directions.push_back(glm::normalize(d));
        }
      }
    }
    while (directions.size() < 16000) directions.push_back(random.direction());
    std::vector<float> x, y, z;
    for (const Vec3& d : directions) {
      x.push_back(d.x);
      y.push_back(d.y);
      z.push_back(d.z);
    }
    ASSERT_EQ(x.size() % simd::kLobeLanes, 0u);
    for (const glm::mat3& world : worlds) {
      for (const auto& [columns, rows, first] :
           {std::tuple(1024, 511, 0.5f), {64, 32, 0.f}, {32, 16, 16.f}}) {
        simd::SphereGrid grid{{}, columns, rows, first};
        for (int i = 0; i < 9; ++i) grid.to_local[i] = world[i / 3][i % 3];
        std::vector<float> places(2 * x.size());
        std::vector<uint32_t> quads(x.size());
        simd::find_places(grid, x.data(), y.data(), z.data(), x.size(), places.data(),
                          quads.data());
        for (size_t i = 0; i < x.size(); ++i) {
          const glm::dvec3 d = glm::dvec3(directions[i]) * glm::dmat3(world);
          const double sine = std::hypot(d.x, d.z);
          const float column = places[2 * i], row = places[2 * i + 1];
          // 1e-7 of the grid and, of a rotation, of the direction: 2e-7 rad.
          EXPECT_NEAR(row, std::atan2(sine, d.y) / kPiD * rows, 2e-7 * rows);
          EXPECT_GE(column, 0);
          EXPECT_LE(column, static_cast<float>(columns));
          double difference = column - (std::atan2(d.x, -d.z) / (2 * kPiD) * columns - first);
          difference -= columns * std::round(difference / columns);
          EXPECT_LE(std::abs(difference) * sine, 2e-7 * columns) << d.x << " " << d.y << " " << d.z;
          const int at = std::min(static_cast<int>(column), columns - 1);
          const int line = std::min(static_cast<int>(row), rows - 1);
          EXPECT_EQ(quads[i], static_cast<uint32_t>(line * columns + at));
        }
      }
    }
  });
}

}  // namespace
}  // namespace kinome::test

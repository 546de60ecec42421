// Compares kernels over directions at surface points with plain code in double precision, for each
// instruction set that this machine can run.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "clustered/kernels/candidate_kernels.h"
#include "kernel_helpers.h"
#include "kinome/warp.h"
#include "support/statistics.h"

namespace kinome::test::lobe_kernels_test {
namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr double kAlpha = 1e-4;  // false-alarm rate of each statistical test

/// A surface point whose lobe is sampled one direction at a time.
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
  /// Returns the density for the half vector of these random numbers, in double precision; 0 if the
  /// half vector is behind the surface.
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

TEST(LobeKernels, DirectionsHaveTheirDensity) {
  for (const auto& [u, v] : {std::pair(0.2f, 0.2f), {0.15f, 0.6f}, {1.f, 1.f}}) {
    for (const float cosine : {0.95f, 0.3f}) {
      const Lobe lobe(u, v, kNormal, cosine);
      // Half vectors behind the viewer lead to directions that reflect nothing.
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

/// Estimates divide by the density. A wrong density biases them by the mean of true / computed.
TEST(LobeKernels, DensitiesOfSharpLobesAreExact) {
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
}

TEST(LobeKernels, ExtremesAreFinite) {
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
}

/// Points of many materials, and directions at the members of a group of some of them.
struct Crowd {
  static constexpr uint32_t kPoints = 700;
  simd::PointFrames frames;
  simd::MicrofacetPoints microfacets;
  std::vector<uint32_t> group, member, numbers[2];
  std::vector<float> d[3], f[3], density;

  Crowd(size_t members, size_t directions, Random& random) {
    frames.resize(kPoints);
    microfacets.resize(kPoints);
    for (uint32_t i = 0; i < kPoints; ++i) {
      const Frame frame = Frame::from_normal(random.direction());
      const Vec3 viewer = glm::normalize(frame.n + 0.6f * random.direction());
      for (int axis = 0; axis < 3; ++axis) {
        frames.normal[axis][i] = frame.n[axis];
        frames.tangent[axis][i] = frame.s[axis];
        frames.viewer[axis][i] = viewer[axis];
        microfacets.specular[axis][i] = random.unit();
      }
      microfacets.alpha_u[i] = 0.1f + random.unit();
      microfacets.alpha_v[i] = 0.1f + random.unit();
    }
    for (size_t i = 0; i < members; ++i) group.push_back(below(random, kPoints));
    for (size_t i = 0; i < directions; ++i) {
      member.push_back(below(random, static_cast<uint32_t>(members)));
      for (auto& n : numbers) n.push_back(static_cast<uint32_t>(random.unit() * 0x1p32));
    }
    resize(directions);
  }
  static uint32_t below(Random& random, uint32_t count) {
    return static_cast<uint32_t>(random.unit() * static_cast<float>(count));
  }
  void resize(size_t directions) {
    for (auto* const v : {&d[0], &d[1], &d[2], &f[0], &f[1], &f[2], &density})
      v->resize(directions);
  }
  void sample_and_evaluate() {
    const simd::PointGroup points{frames, group.data(), group.size()};
    const simd::HalfVectorLobe lobe{0.3f, 0.5f};
    simd::sample_lobe(lobe, points, member.data(), {numbers[0].data(), numbers[1].data(), {0, 0}},
                      member.size(), d[0].data(), d[1].data(), d[2].data());
    simd::evaluate_microfacets({true, false, {1.5f, 1.5f, 1.5f}, {}}, {0.1f, 0.1f, {1, 1, 1}},
                               &microfacets, lobe, points, member.data(), d[0].data(), d[1].data(),
                               d[2].data(), member.size(),
                               {{f[0].data(), f[1].data(), f[2].data()}, density.data()});
  }
  /// Returns the i-th direction alone, at a group of one point.
  Crowd alone(size_t i) const {
    Crowd one = *this;
    one.group = {group[member[i]]};
    one.member.assign(simd::kLobeLanes, 0);
    for (int k = 0; k < 2; ++k) one.numbers[k].assign(simd::kLobeLanes, numbers[k][i]);
    one.resize(simd::kLobeLanes);
    return one;
  }
};

/// Tests groups of one vector, of several vectors, and smaller ones; with fewer directions than
/// members, and with more.
TEST(LobeKernels, DirectionsAreOfTheirMembers) {
  Random random(3);
  for (const size_t members : {1, 3, 4, 5, 15, 16, 17, 33, 64, 127, 128, 129, 500}) {
    for (const size_t directions : {size_t{16}, 40 * simd::kLobeLanes}) {
      Crowd crowd(members, directions, random);
      crowd.sample_and_evaluate();
      for (int repeat = 0; repeat < 30; ++repeat) {
        const size_t i = Crowd::below(random, static_cast<uint32_t>(directions));
        Crowd one = crowd.alone(i);
        one.sample_and_evaluate();
        for (int k = 0; k < 3; ++k) {
          EXPECT_EQ(crowd.d[k][i], one.d[k][0]) << members << " members, direction " << i;
          EXPECT_EQ(crowd.f[k][i], one.f[k][0]) << members << " members, direction " << i;
        }
        EXPECT_EQ(crowd.density[i], one.density[0]);
      }
    }
  }
}

/// Tests positions on a grid of directions: random ones, on the axes, and next to them.
TEST(LobeKernels, PositionsMatchTheLibrary) {
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
      simd::find_places(grid, x.data(), y.data(), z.data(), x.size(), places.data(), quads.data());
      for (size_t i = 0; i < x.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(directions[i]) * glm::dmat3(world);
        const double sine = std::hypot(d.x, d.z);
        const float column = places[2 * i], row = places[2 * i + 1];
        // Tolerance: 1e-7 of the grid, and of the rotated direction: 2e-7 rad.
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
}

}  // namespace
}  // namespace kinome::test::lobe_kernels_test

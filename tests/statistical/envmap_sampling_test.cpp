/// Tests that directions toward environment maps are sampled by their density.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "envmap_cases.h"
#include "kinome/clustered_light.h"
#include "kinome/warp.h"
#include "support/statistics.h"

namespace kinome::test::envmap_sampling_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 50 statistical tests

/// chi² test of sample_direct() against pdf_environment() by cells. The density must integrate to
/// 1.
void expect_sampled_by_its_pdf(const Emitter& emitter, const Grid& grid, int samples, bool turned,
                               const std::string& name) {
  const auto pdf = [&](const glm::dvec3& d) {
    return static_cast<double>(emitter.pdf_environment(Vec3(turned ? rotated(d) : d)));
  };
  std::vector<double> expected(static_cast<size_t>(grid.columns) * grid.rows);
  std::vector<double> observed(expected.size());
  double total = 0;
  for (int y = 0; y < grid.rows; ++y) {
    for (int x = 0; x < grid.columns; ++x) {
      const double p = grid.integrate(x, y, pdf);
      total += p;
      expected[static_cast<size_t>(y) * grid.columns + x] = p * samples;
    }
  }
  // Each density has a relative rounding error of about 1e-6, because texel coordinates are floats.
  EXPECT_NEAR(total, 1, 2e-5) << name;
  std::mt19937 rng(17);
  for (int i = 0; i < samples; ++i) {
    const auto sample = emitter.sample_direct(Vec3(0.f), random_pair(rng));
    ASSERT_TRUE(sample) << name;
    const glm::dvec3 d(sample->d);
    size_t cell = grid.cell(coordinates(turned ? unrotated(d) : d));
    // A direction on the border of a black cell may round into it.
    if (expected[cell] == 0) {
      const glm::dvec3 local = turned ? unrotated(d) : d;
      for (const auto& nudge : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
        for (const double step : {-3e-7, 3e-7}) {
          const size_t beside = grid.cell(coordinates(local + step * nudge));
          if (expected[cell] == 0) cell = beside;
        }
      }
    }
    observed[cell] += 1;
  }
  const auto verdict = chi2_test(observed, expected, kAlpha);
  EXPECT_TRUE(verdict.passed) << name << ": " << verdict.text;
}

TEST(EnvironmentMap, IsSampledByItsDensity) {
  for (const Map& map : maps()) {
    const Grid grid(map.width, map.height, 3);
    expect_sampled_by_its_pdf(*envmap(map), grid, 200000, false, map.name);
  }
}

TEST(EnvironmentMap, IsSampledByItsDensityWhenRotated) {
  for (const Map& map : maps()) {
    const Grid grid(map.width, map.height, 2);
    expect_sampled_by_its_pdf(*envmap(map, kRotation), grid, 50000, true, map.name);
  }
}

TEST(EnvironmentMap, IsSampledByItsCompensatedDensity) {
  for (const Map& map : maps()) {
    const auto emitter = envmap(map, "<boolean name=\"mis_compensation\" value=\"true\"/>");
    expect_sampled_by_its_pdf(*emitter, Grid(map.width, map.height, 2), 50000, false, map.name);
  }
}

TEST(EnvironmentMap, SamplesAPhotographByItsDensity) {
  const std::string path = "/usr/share/blender/datafiles/studiolights/world/city.exr";
  ASSERT_TRUE(std::filesystem::exists(path)) << "missing; install the package blender-data";
  expect_sampled_by_its_pdf(*envmap(path), Grid(1024, 512, 1), 2000000, false, "city");
}

/// With or without compensation, the density is zero only in directions without light.
TEST(EnvironmentMap, HasADensityWhereverThereIsLight) {
  std::mt19937 rng(3);
  std::normal_distribution<float> normal;
  for (const Map& map : maps()) {
    for (const char* compensation : {"false", "true"}) {
      const auto emitter = envmap(
          map, std::string("<boolean name=\"mis_compensation\" value=\"") + compensation + "\"/>");
      for (int i = 0; i < 20000; ++i) {
        const Vec3 d = glm::normalize(Vec3(normal(rng), normal(rng), normal(rng)));
        const float pdf = emitter->pdf_environment(d);
        ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << map.name;
        ASSERT_TRUE(pdf > 0 || is_black(emitter->eval_environment(d))) << map.name;
      }
    }
  }
}

/// Around both poles all values are finite, and nonzero in directions with light.
TEST(EnvironmentMap, IsFiniteAtThePoles) {
  for (const Map& map : maps()) {
    const auto emitter = envmap(map);
    for (const float y : {1.f, -1.f}) {
      for (const float r : {0.f, 1e-30f, 1e-12f, 1e-8f, 1e-6f, 9.99e-4f, 1.001e-3f, 1e-2f}) {
        for (const float phi : {0.f, 1.f, 2.f, 4.f}) {
          const Vec3 d(r * std::sin(phi), y * std::sqrt(1 - r * r), -r * std::cos(phi));
          const float pdf = emitter->pdf_environment(d);
          const Rgb radiance = emitter->eval_environment(d);
          ASSERT_TRUE(is_finite(radiance));
          ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << map.name;
          ASSERT_EQ(pdf > 0, !is_black(radiance))
              << map.name << " at r = " << r << ", phi = " << phi << ", y = " << y << ", pdf "
              << pdf << ", radiance " << radiance.x;
        }
      }
    }
  }
}

/// The density is proportional to the evaluated map: luminance / pdf is constant, except for the
/// error of interpolated sines (1.3e-3 with the fewest rows) and for texels of mixed sign.
TEST(EnvironmentMap, DensityFollowsTheEvaluatedMap) {
  const auto emitter = envmap(Map{"noise", 16, 9, noise});
  std::mt19937 rng(4);
  std::normal_distribution<float> normal;
  double lowest = 1e30, highest = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 d = glm::normalize(Vec3(normal(rng), normal(rng), normal(rng)));
    const double ratio = luminance(emitter->eval_environment(d)) / emitter->pdf_environment(d);
    lowest = std::min(lowest, ratio);
    highest = std::max(highest, ratio);
  }
  EXPECT_LT(highest / lowest, 1 + 2e-3);
}

/// A sample agrees with the evaluated map. Texel coordinates have a rounding error of about 1e-6
/// texels here, and neighbouring texels of `noise` differ by a factor of up to 11.
TEST(EnvironmentMap, SamplesAgreeWithEvaluation) {
  std::mt19937 rng(5);
  for (const std::string& rotation : {std::string(), kRotation}) {
    const auto emitter = envmap(Map{"noise", 16, 9, noise}, rotation);
    for (int i = 0; i < 20000; ++i) {
      const auto sample = emitter->sample_direct(Vec3(0.f), random_pair(rng));
      ASSERT_TRUE(sample);
      ASSERT_NEAR(glm::length(sample->d), 1, 1e-6);
      ASSERT_NEAR(emitter->pdf_environment(sample->d) / sample->pdf, 1, 1e-4);
      const Rgb radiance = emitter->eval_environment(sample->d);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(radiance[c] / sample->radiance[c], 1, 1e-4);
      ASSERT_EQ(sample->distance, kInfinity);
      ASSERT_FALSE(sample->is_delta);
    }
  }
}

/// Batches return the same values as single calls.
TEST(EnvironmentMap, BatchesEqualSingleCalls) {
  const Map black{"black", 4, 3, [](int, int) { return Rgb(0.f); }};
  std::mt19937 rng(6);
  for (const auto& emitter : {envmap(Map{"noise", 16, 9, noise}, kRotation), envmap(black),
                              make<Emitter>("<emitter type=\"constant\"/>")}) {
    for (const size_t count : {0u, 1u, 63u, 64u, 65u, 200u}) {
      std::vector<Vec3> d(count);
      for (Vec3& direction : d) direction = square_to_uniform_sphere(random_pair(rng));
      std::vector<Rgb> radiance(count), alone(count);
      std::vector<float> pdf(count);
      eval_environment(*emitter, d, radiance, pdf);
      eval_environment(*emitter, d, alone);
      for (size_t i = 0; i < count; ++i) {
        ASSERT_EQ(radiance[i], emitter->eval_environment(d[i]));
        ASSERT_EQ(pdf[i], emitter->pdf_environment(d[i]));
      }
      ASSERT_EQ(radiance, alone);
    }
  }
}

TEST(EnvironmentMap, DensityIsTheInverseJacobian) {
  for (const std::string& rotation : {std::string(), kRotation}) {
    const auto emitter = envmap(Map{"noise", 8, 5, noise}, rotation);
    const auto sample = [&](Vec2 u) -> std::optional<Vec3> {
      const auto direct = emitter->sample_direct(Vec3(0.f), u);
      return direct ? std::optional(direct->d) : std::nullopt;
    };
    const auto pdf = [&](const Vec3& d) { return emitter->pdf_environment(d); };
    const auto verdict = jacobian_test(sample, pdf, 2000, 2e-3);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

}  // namespace
}  // namespace kinome::test::envmap_sampling_test

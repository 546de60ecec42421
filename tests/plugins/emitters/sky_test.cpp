/// Tests of environments of which only the radiance is known (Sky), and of the functions that
/// ClusteredLight derives for them.
#include "kinome/sky.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinome/clustered_light.h"
#include "support/block_memory.h"
#include "support/render.h"

namespace kinome::test::sky_test {
namespace {

/// A sky with a bright disk of 10 degrees and a dim remainder.
class Moonlit final : public Sky {
 public:
  Rgb radiance(const Vec3& d) const override {
    const Vec3 moon = glm::normalize(Vec3(1, 2, -1));
    return glm::dot(d, moon) > std::cos(0.0873f) ? Rgb(40, 30, 20) : Rgb(0.1f) * (1 + d.y);
  }
};

class Black final : public Sky {
 public:
  Rgb radiance(const Vec3&) const override { return Rgb(0.f); }
};

/// Solid angle times radiance, channel 0.
double flux_of_moonlit() {
  const double disk = 2 * M_PI * (1 - std::cos(0.0873));
  const double y = 2 / std::sqrt(6.);  // of the centre: nearly the mean over the disk
  return 0.1 * (4 * M_PI - disk * (1 + y)) + 40 * disk;
}

TEST(Sky, SamplesHaveTheirDensityAndRadiance) {
  const Moonlit sky;
  double sum = 0, squares = 0;
  constexpr int kSide = 256;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u(static_cast<float>((i % kSide) + 0.5) / kSide,
                 static_cast<float>((i / kSide) + 0.5) / kSide);
    const auto sample = sky.sample_direct(Vec3(0.f), u);
    ASSERT_TRUE(sample);
    ASSERT_NEAR(glm::length(sample->d), 1, 1e-5);
    ASSERT_GT(sample->pdf, 0);
    EXPECT_EQ(sample->pdf, sky.pdf_environment(sample->d));
    EXPECT_EQ(sample->radiance, sky.eval_environment(sample->d));
    const double weight = static_cast<double>(sample->radiance.x / sample->pdf);
    sum += weight;
    squares += weight * weight;
  }
  const double mean = sum / (kSide * kSide), expected = flux_of_moonlit();
  EXPECT_NEAR(mean, expected, 5e-3 * expected);
  // Uniform directions have a relative variance of some 70.
  EXPECT_LT(squares / (kSide * kSide) / (mean * mean) - 1, 0.5);
}

/// The density integrates to 1, and is positive everywhere.
TEST(Sky, DensityIsNormalised) {
  const Moonlit sky;
  constexpr int kRows = 1024, kColumns = 2048;
  double sum = 0;
  for (int row = 0; row < kRows; ++row) {
    const float z = 1 - 2 * (static_cast<float>(row) + 0.5f) / kRows;
    const float r = std::sqrt(1 - z * z);
    for (int column = 0; column < kColumns; ++column) {
      const float phi = 2 * kPi * (static_cast<float>(column) + 0.5f) / kColumns;
      const float pdf = sky.pdf_environment({r * std::cos(phi), r * std::sin(phi), z});
      ASSERT_GT(pdf, 0);
      sum += static_cast<double>(pdf);
    }
  }
  EXPECT_NEAR(sum * 4 * M_PI / (double{kRows} * kColumns), 1, 1e-3);
}

/// Blocks have the samples and densities of single calls, up to the rounding of their functions.
TEST(Sky, BlocksAreAsPoints) {
  constexpr size_t kCount = 501;
  const Moonlit moonlit;
  const Black black;
  for (const Sky* const sky : std::initializer_list<const Sky*>{&moonlit, &black}) {
    BlockMemory memory(kCount);
    const Columns2 u = memory.two();
    const DirectBlock out{memory.three(), memory.one(), memory.one(), memory.three(),
                          memory.one()};
    const Columns3 radiance = memory.three();
    float* const pdf = memory.one();
    for (size_t i = 0; i < kCount; ++i) {
      const uint64_t bits = hash_words(5, i, 0);
      u.set(i, {static_cast<float>(bits >> 40) * 0x1p-24f,
                static_cast<float>((bits >> 8) & 0xffffff) * 0x1p-24f});
    }
    sky->sample_direct_block(out.d, u, kCount, out);
    sky->eval_environment_block(out.d, kCount, radiance, pdf);
    size_t at_borders = 0;
    for (size_t i = 0; i < kCount; ++i) {
      const auto sample = sky->sample_direct(Vec3(0.f), u.at(i));
      ASSERT_TRUE(sample);
      EXPECT_LT(glm::length(out.d.at(i) - sample->d), 1e-5f);
      EXPECT_EQ(out.distance[i], kInfinity);
      EXPECT_EQ(out.is_delta[i], 0.f);
      EXPECT_EQ(out.radiance.at(i), sky->radiance(out.d.at(i)));
      EXPECT_EQ(radiance.at(i), out.radiance.at(i));
      EXPECT_EQ(pdf[i], out.pdf[i]);
      // Near the border of two cells, rounding may choose the other one.
      if (std::abs(out.pdf[i] - sample->pdf) > 1e-3f * sample->pdf) ++at_borders;
    }
    EXPECT_LE(at_borders, kCount / 50);
  }
}

TEST(Sky, BlackOneIsSampledUniformly) {
  const Black sky;
  const auto sample = sky.sample_direct(Vec3(0.f), {0.3f, 0.6f});
  ASSERT_TRUE(sample);
  EXPECT_FLOAT_EQ(sample->pdf, 1 / (4 * kPi));
  EXPECT_EQ(sample->radiance, Rgb(0.f));
}

TEST(Sky, EmissionHasTheDensityAndRadianceOfItsDirection) {
  Moonlit sky;
  sky.prepare(Aabb{Vec3(-1.f), Vec3(1.f)});
  const auto ray = sky.sample_emission({0.2f, 0.7f}, {0.4f, 0.5f});
  ASSERT_TRUE(ray);
  const auto density = sky.emission_density(ray->d);
  ASSERT_TRUE(density);
  EXPECT_FLOAT_EQ(ray->pdf_direction, density->direction);
  EXPECT_FLOAT_EQ(ray->pdf_position, density->position);
  const Rgb radiance = sky.radiance(-ray->d);
  EXPECT_NEAR(ray->power.x, radiance.x / (ray->pdf_direction * ray->pdf_position),
              1e-5f * ray->power.x);
}

TEST(ClusteredLight, IsDerivedFromTheRadianceOfAnEnvironment) {
  const Moonlit sky;
  EXPECT_EQ(clustered_light(sky), nullptr);
  ASSERT_TRUE(cell_grid_of(sky));
  EXPECT_FALSE(cell_grid_of(sky)->smooth_quads);
  const auto scene = scene_from("<shape type=\"sphere\"/>");
  RenderContext context({.threads = 1});
  const auto points = light_points_of(sky, *scene, context, 4096);
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 4096u);
  double sum = 0;
  for (const Rgb& power : points->power) sum += static_cast<double>(power.x);
  EXPECT_NEAR(sum, flux_of_moonlit(), 0.02 * flux_of_moonlit());
}

}  // namespace
}  // namespace kinome::test::sky_test

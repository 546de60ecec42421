#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>

#include "kinome/emitter.h"
#include "kinome/image.h"
#include "kinome/sphere_partition.h"
#include "support/render.h"
#include "support/statistics.h"

namespace kinome {
namespace {

constexpr double kAlpha = 1e-4;  // of each statistical test here: about 50 in all
constexpr double kPiD = 3.14159265358979323846;

using Texel = std::function<Rgb(int x, int y)>;

struct Map {
  const char* name;
  int width;
  int height;
  Texel texel;
};

Rgb noise(int x, int y) {
  const auto unit = [&](int c) { return static_cast<float>((x * 7 + y * 13 + c * 5) % 11); };
  return 0.125f * Rgb(1 + unit(0), 1 + unit(1), 1 + unit(2));
}

/// Maps that break samplers: suns where coordinates are singular, signs, degenerate sizes.
std::vector<Map> maps() {
  const auto sun_at = [](int sun_x, int sun_y, float sky) {
    return [=](int x, int y) { return x == sun_x && y == sun_y ? Rgb(2000, 1500, 900) : Rgb(sky); };
  };
  return {
      {"noise", 16, 9, noise},
      {"sun at the upper pole", 16, 9, sun_at(5, 0, 0.1f)},
      {"sun at the lower pole", 16, 9, sun_at(0, 8, 0.1f)},
      {"lone sun at the pole", 8, 33, sun_at(3, 0, 0)},
      {"lone sun beside the pole", 8, 33, sun_at(3, 1, 0)},
      {"sun on the seam, left", 16, 9, sun_at(0, 3, 0.1f)},
      {"sun on the seam, right", 16, 9, sun_at(15, 3, 0.1f)},
      {"negative texels", 16, 9,
       [](int x, int y) { return noise(x, y) - ((x + y) % 5 == 0 ? Rgb(1.5f) : Rgb(0.f)); }},
      {"all negative", 4, 4, [](int x, int y) { return -noise(x, y); }},
      {"1 x 1", 1, 1, noise},
      {"2 x 2", 2, 2, noise},
      {"1 x 7", 1, 7, noise},
      {"7 x 1", 7, 1, noise},
      {"3 x 2, half black", 3, 2, [](int x, int y) { return Rgb(x == 1 && y == 1 ? 1.f : 0.f); }},
      {"huge range", 8, 5, [](int x, int y) { return Rgb((x + y) % 3 ? 1e-20f : 1e12f); }},
  };
}

Image image_of(int width, int height, const Texel& texel) {
  Image image{width, height, {"R", "G", "B"}, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = texel(x, y);
      image.data.insert(image.data.end(), {c.x, c.y, c.z});
    }
  }
  return image;
}

std::shared_ptr<Emitter> envmap(const std::string& path, const std::string& more = "") {
  return test::make<Emitter>("<emitter type=\"envmap\"><string name=\"filename\" value=\"" + path +
                             "\"/>" + more + "</emitter>");
}

std::shared_ptr<Emitter> envmap(const Map& map, const std::string& more = "") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("map.pfm");
  write_pfm(path, image_of(map.width, map.height, map.texel));
  return envmap(path, more);
}

const std::string kRotation =
    "<transform name=\"to_world\"><rotate y=\"1\" angle=\"30\"/>"
    "<rotate x=\"1\" angle=\"-50\"/></transform>";

/// The rotation of kRotation, in doubles.
glm::dvec3 rotated(const glm::dvec3& d) {
  const double a = 30 * kPiD / 180, b = -50 * kPiD / 180;
  const glm::dvec3 y(std::cos(a) * d.x + std::sin(a) * d.z, d.y,
                     -std::sin(a) * d.x + std::cos(a) * d.z);
  return {y.x, std::cos(b) * y.y - std::sin(b) * y.z, std::sin(b) * y.y + std::cos(b) * y.z};
}
glm::dvec3 unrotated(const glm::dvec3& d) {
  // The inverse is the transpose: its rows are the images of the axes.
  return {glm::dot(rotated({1, 0, 0}), d), glm::dot(rotated({0, 1, 0}), d),
          glm::dot(rotated({0, 0, 1}), d)};
}

glm::dvec3 direction(double u, double v) {
  const double phi = 2 * kPiD * u, theta = kPiD * v;
  return {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
}

struct Coordinates {
  double u;
  double v;
};
Coordinates coordinates(const glm::dvec3& d) {
  double u = std::atan2(d.x, -d.z) / (2 * kPiD);
  if (u < 0) u += 1;
  return {u, std::atan2(std::hypot(d.x, d.z), d.y) / kPiD};
}

/// A grid over (u, v) whose lines include those where a map's interpolation has kinks: within a
/// cell, pdf x sin theta is linear in u and quadratic in v, and two Gauss points an axis integrate
/// it exactly.
struct Grid {
  int columns;
  int rows;
  double shift;  ///< of the first line: half a texel

  Grid(int width, int height, int parts)
      : columns(width * parts), rows(std::max(1, height - 1) * parts), shift(0.5 / width) {
    // Maps of few rows are refined by whole factors, to 32 gaps at least.
    if (height - 1 < 32) rows *= (31 + std::max(1, height - 1)) / std::max(1, height - 1);
  }

  template <class Function>
  double integrate(int column, int row, const Function& f) const {
    constexpr double kNodes[] = {0.21132486540518713, 0.78867513459481287};
    double sum = 0;
    for (const double s : kNodes) {
      for (const double t : kNodes) {
        const double v = (row + t) / rows;
        sum += f(direction(shift + (column + s) / columns, v)) * std::sin(kPiD * v);
      }
    }
    return sum * 0.25 * 2 * kPiD * kPiD / (static_cast<double>(columns) * rows);
  }
  template <class Function>
  double integrate(const Function& f) const {
    double sum = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) sum += integrate(x, y, f);
    }
    return sum;
  }
  size_t cell(const Coordinates& at) const {
    double u = at.u - shift;
    u -= std::floor(u);
    const int x = std::min(static_cast<int>(u * columns), columns - 1);
    const int y = std::min(static_cast<int>(at.v * rows), rows - 1);
    return static_cast<size_t>(y) * columns + x;
  }
};

Vec2 random_pair(std::mt19937& rng) {
  const auto x = static_cast<float>(rng() >> 8), y = static_cast<float>(rng() >> 8);
  return Vec2(x, y) * 0x1p-24f;
}

/// chi² of sample_direct against pdf_environment, cell by cell; the density must integrate to 1.
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
  // Each density has a relative rounding error of some 1e-6 (texel coordinates are floats).
  EXPECT_NEAR(total, 1, 2e-5) << name;
  std::mt19937 rng(17);
  for (int i = 0; i < samples; ++i) {
    const auto sample = emitter.sample_direct(Vec3(0.f), random_pair(rng));
    ASSERT_TRUE(sample) << name;
    const glm::dvec3 d(sample->d);
    size_t cell = grid.cell(coordinates(turned ? unrotated(d) : d));
    // A direction on the border of a cell of no light may round into it.
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
  const auto verdict = test::chi2_test(observed, expected, kAlpha);
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
  ASSERT_TRUE(std::filesystem::exists(path)) << "needs the package blender-data";
  expect_sampled_by_its_pdf(*envmap(path), Grid(1024, 512, 1), 2000000, false, "city");
}

/// Compensated or not, the density is zero only where there is no light.
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

/// In directions around both poles nothing is infinite, nor zero where there is light.
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

/// Density proportional to the evaluated map: luminance / pdf is one number, but for what
/// interpolating sines adds (1.3e-3 where rows are fewest) and for texels of mixed sign.
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

/// What a sample says of its direction is what the map says of it. Texel coordinates have a
/// rounding error of about 1e-6 texels here, and neighbouring texels of `noise` differ by a factor
/// of up to 11.
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

/// Batches are a matter of speed alone.
TEST(EnvironmentMap, BatchesEqualSingleCalls) {
  const Map black{"black", 4, 3, [](int, int) { return Rgb(0.f); }};
  std::mt19937 rng(6);
  for (const auto& emitter : {envmap(Map{"noise", 16, 9, noise}, kRotation), envmap(black),
                              test::make<Emitter>("<emitter type=\"constant\"/>")}) {
    for (const size_t count : {0u, 1u, 63u, 64u, 65u, 200u}) {
      std::vector<Vec3> p(count), d(count);
      std::vector<Vec2> u(count);
      for (Vec2& pair : u) pair = random_pair(rng);
      std::vector<DirectSample> samples(count);
      emitter->sample_direct_batch(p, u, samples);
      for (size_t i = 0; i < count; ++i) {
        const auto single = emitter->sample_direct(p[i], u[i]);
        ASSERT_EQ(samples[i].pdf, single ? single->pdf : 0);
        d[i] = samples[i].d;
        if (!single) continue;
        ASSERT_EQ(samples[i].d, single->d);
        ASSERT_EQ(samples[i].radiance, single->radiance);
        ASSERT_EQ(samples[i].distance, kInfinity);
      }
      std::vector<Rgb> radiance(count), alone(count);
      std::vector<float> pdf(count);
      emitter->eval_environment_batch(d, radiance, pdf);
      emitter->eval_environment_batch(d, alone, {});
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
    const auto verdict = test::jacobian_test(sample, pdf, 2000, 2e-3);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

struct Reference {
  Vec3 d;
  Rgb radiance;
};

/// Mitsuba 3.9.1, scalar_rgb: `envmap` of the 5 x 4 bitmap noise(x, y), scale 2, without and with
/// to_world = rotate(x, -50) rotate(y, 30); eval() of an interaction whose wi is -d. Eight normal
/// random directions each, rounded to the six digits that stand here.
const Reference kPlain[] = {
    {{0.618984f, -0.775100f, 0.126804f}, {0.512654f, 1.677556f, 1.898463f}},
    {{-0.749577f, -0.597593f, -0.284634f}, {1.833304f, 1.767022f, 1.583304f}},
    {{-0.914149f, -0.104961f, -0.391554f}, {1.801274f, 1.478170f, 1.551274f}},
    {{0.992154f, 0.067414f, -0.105286f}, {1.335459f, 1.551919f, 1.883057f}},
    {{-0.219732f, -0.521855f, -0.824248f}, {2.275893f, 1.608448f, 2.025893f}},
    {{-0.587884f, 0.724993f, -0.358857f}, {1.800392f, 0.926642f, 1.550392f}},
    {{0.978625f, -0.204155f, 0.024788f}, {0.971155f, 1.578015f, 2.195933f}},
    {{0.901241f, 0.317806f, -0.294557f}, {1.456047f, 1.596958f, 1.468170f}},
};
const Reference kTurned[] = {
    {{-0.090628f, 0.267923f, 0.959168f}, {1.531195f, 1.417396f, 1.281195f}},
    {{-0.252895f, -0.228450f, 0.940136f}, {1.410663f, 2.221484f, 1.160663f}},
    {{-0.690153f, -0.227119f, 0.687100f}, {1.544524f, 1.979826f, 1.294524f}},
    {{0.651207f, 0.102690f, 0.751920f}, {1.538720f, 0.772278f, 2.014165f}},
    {{-0.896026f, 0.323573f, -0.304037f}, {1.617249f, 1.161845f, 1.367249f}},
    {{-0.911463f, 0.151005f, 0.382664f}, {1.484873f, 1.728147f, 1.234873f}},
    {{-0.381785f, -0.923979f, 0.022425f}, {1.869612f, 1.777668f, 1.619612f}},
    {{-0.033115f, 0.882453f, 0.469233f}, {1.206453f, 1.997232f, 0.956453f}},
};

TEST(EnvironmentMap, EvaluatesAsMitsubaDoes) {
  const Map map{"noise", 5, 4, noise};
  const std::string scale = "<float name=\"scale\" value=\"2\"/>";
  const auto plain = envmap(map, scale), turned = envmap(map, scale + kRotation);
  const auto compare = [](const Emitter& emitter, const Reference& reference) {
    const Rgb radiance = emitter.eval_environment(glm::normalize(reference.d));
    // Six printed digits of d move it by less than 1e-6; a gradient is below 2.75 x 5 / 2 pi.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], reference.radiance[c], 1e-5);
  };
  for (const Reference& reference : kPlain) compare(*plain, reference);
  for (const Reference& reference : kTurned) compare(*turned, reference);
}

TEST(EnvironmentMap, HitsEachTexelAtItsCentre) {
  const Map map{"noise", 6, 5, noise};
  const auto emitter = envmap(map);
  for (int y = 1; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) {
      const Rgb radiance = emitter->eval_environment(Vec3(direction((x + 0.5) / 6, y / 4.)));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], noise(x, y)[c], 1e-5) << x << "," << y;
    }
  }
}

/// What is not a number is told by the film: it must come through, and read nothing foreign.
TEST(EnvironmentMap, PassesOnDirectionsThatAreNoNumbers) {
  const auto emitter = envmap(Map{"noise", 6, 5, noise});
  for (int axis = 0; axis < 3; ++axis) {
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      Vec3 d(0.6f, 0.6f, 0.5f);
      d[axis] = bad;
      EXPECT_FALSE(is_finite(emitter->eval_environment(d))) << axis << " " << bad;
    }
  }
}

TEST(EnvironmentMap, BlackHasNothingToSample) {
  const auto emitter = envmap(Map{"black", 4, 3, [](int, int) { return Rgb(0.f); }});
  EXPECT_FALSE(emitter->sample_direct(Vec3(0.f), Vec2(0.5f)));
  EXPECT_EQ(emitter->pdf_environment(Vec3(0, 1, 0)), 0);
  const auto points = test::light_points_of(*emitter, 10, 0);
  ASSERT_TRUE(points);
  for (const Rgb& power : points->power) EXPECT_TRUE(is_black(power));
}

TEST(EnvironmentMap, LightPointsKeepTheFlux) {
  for (const Map& map : maps()) {
    const auto emitter = envmap(map);
    // The map itself is linear in u and v within the grid's cells, times sin theta: a fine grid.
    const Grid grid(map.width, map.height, 4);
    glm::dvec3 expected(0), magnitude(0);
    for (int c = 0; c < 3; ++c) {
      const auto channel = [&](const glm::dvec3& d) {
        return static_cast<double>(emitter->eval_environment(Vec3(d))[c]);
      };
      expected[c] = grid.integrate(channel);
      magnitude[c] = grid.integrate([&](const glm::dvec3& d) { return std::abs(channel(d)); });
    }
    for (const uint32_t count : {1u, 2u, 100u, 3000u}) {
      const auto points = test::light_points_of(*emitter, count, 1);
      ASSERT_TRUE(points);
      ASSERT_EQ(points->kind, LightPoints::Kind::kDistant);
      ASSERT_EQ(points->size(), count);
      ASSERT_EQ(points->power.size(), count);
      ASSERT_EQ(points->extent.size(), count);
      ASSERT_TRUE(points->normal.empty());
      glm::dvec3 sum(0);
      for (const Rgb& power : points->power) sum += glm::dvec3(power);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sum[c], expected[c], 1e-5 * magnitude[c]) << map.name << ", " << count;
      }
    }
  }
}

/// Each point has the light of its own cell: the mean over the cell times its solid angle.
TEST(EnvironmentMap, LightPointsHaveTheLightOfTheirCells) {
  const Map map{"noise", 9, 6, noise};
  const auto emitter = envmap(map, kRotation);
  for (const uint32_t count : {1u, 5u, 64u, 2000u}) {
    const SpherePartition cells(count);
    const auto points = test::light_points_of(*emitter, count, 1);
    const int steps = count < 100 ? 300 : 40;
    for (uint32_t i = 0; i < count; ++i) {
      const Vec3 centre(rotated(glm::dvec3(cells.centre(i))));
      ASSERT_LT(glm::length(points->position[i] - centre), 1e-5);
      glm::dvec3 mean(0);
      for (int y = 0; y < steps; ++y) {
        for (int x = 0; x < steps; ++x) {
          const Vec3 d = cells.sample(i, Vec2(x + 0.5f, y + 0.5f) / static_cast<float>(steps));
          mean += glm::dvec3(emitter->eval_environment(Vec3(rotated(glm::dvec3(d)))));
        }
      }
      mean /= steps * steps;
      // The midpoint rule's error is of the step squared: the largest, of one cell for the whole
      // sphere, has steps of 9 / 300 texels along phi.
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(points->power[i][c] / (mean[c] * points->extent[i]), 1, 5e-4)
            << "cell " << i << " of " << count;
      }
    }
  }
}

TEST(EnvironmentMap, LightPointsOfAUniformMapAreEqual) {
  const auto emitter = envmap(Map{"white", 64, 32, [](int, int) { return Rgb(1, 2, 3); }});
  const auto points = test::light_points_of(*emitter, 777, 0);
  for (size_t i = 0; i < points->size(); ++i) {
    EXPECT_NEAR(points->power[i].y, 2 * points->extent[i], 1e-5 * points->extent[i]);
    EXPECT_NEAR(points->extent[i], 4 * kPi / 777, 1e-8);
  }
}

// ---- bad input ----

std::string error_of(const std::function<void()>& make) {
  try {
    make();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(EnvironmentMap, NamesTheTexelThatIsNoNumber) {
  for (const auto& [value, what] :
       {std::pair{NAN, "NaN"}, {INFINITY, "infinite"}, {-INFINITY, "infinite"}, {1e37f, "large"}}) {
    const float bad = value;
    const Map map{"bad", 6, 4,
                  [bad](int x, int y) { return x == 4 && y == 2 ? Rgb(1, bad, 1) : Rgb(1.f); }};
    const std::string message = error_of([&] { envmap(map); });
    EXPECT_NE(message.find(" at x = 4, y = 2, channel G; "), std::string::npos) << message;
    EXPECT_NE(message.find("'filename' has a texel that is "), std::string::npos) << message;
    EXPECT_NE(message.find(std::isfinite(bad) ? "stay below 1e36" : "radiance must be finite"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_EQ(message.rfind("test.xml:1:", 0), 0u) << message;
  }
}

TEST(EnvironmentMap, WarnsOnceOfNegativeTexels) {
  testing::internal::CaptureStderr();
  envmap(Map{"negative", 4, 4, [](int x, int) { return Rgb(x == 1 ? -0.25f : 1.f); }});
  const std::string warning = testing::internal::GetCapturedStderr();
  EXPECT_NE(warning.find("'filename' has 4 negative texels, which are kept"), std::string::npos)
      << warning;
  EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
}

TEST(EnvironmentMap, RefusesWhatItCannotRead) {
  const test::TemporaryFolder folder;
  const std::string message = error_of([&] { envmap(folder.write("sky.png", "PNG")); });
  EXPECT_NE(message.find(".exr or .pfm"), std::string::npos) << message;
  EXPECT_NE(error_of([&] { envmap(folder.write("sky.exr", "no image")); }), "");
  EXPECT_NE(error_of([&] { envmap(folder.path("missing.exr")); }), "");
  const Map map{"noise", 4, 3, noise};
  EXPECT_NE(error_of([&] { envmap(map, "<float name=\"scale\" value=\"-1\"/>"); }), "");
  const std::string stretched = error_of(
      [&] { envmap(map, "<transform name=\"to_world\"><scale value=\"2\"/></transform>"); });
  EXPECT_NE(stretched.find("rotation"), std::string::npos) << stretched;
}

// ---- constant ----

TEST(ConstantEnvironment, IsUniform) {
  const auto emitter = test::make<Emitter>(
      "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1 2 3\"/></emitter>");
  test::SphereChi2 chi2;
  chi2.sample = [&](float, Vec2 u) { return std::optional(emitter->sample_direct({}, u)->d); };
  chi2.pdf = [&](const Vec3& d) { return emitter->pdf_environment(d); };
  chi2.samples = 200000;
  const auto verdict = test::sphere_chi2_test(chi2, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
  EXPECT_EQ(emitter->eval_environment(Vec3(0, 0, 1)), Rgb(1, 2, 3));
  const auto points = test::light_points_of(*emitter, 1000, 0);
  Rgb sum(0.f);
  for (const Rgb& power : points->power) sum += power;
  EXPECT_NEAR(sum.z, 12 * kPi, 1e-4 * 12 * kPi);
}

TEST(ConstantEnvironment, BlackHasNothingToSample) {
  const auto emitter = test::make<Emitter>(
      "<emitter type=\"constant\"><float name=\"radiance\" value=\"0\"/></emitter>");
  EXPECT_FALSE(emitter->sample_direct({}, Vec2(0.5f)));
  EXPECT_EQ(emitter->pdf_environment(Vec3(0, 0, 1)), 0);
}

}  // namespace
}  // namespace kinome

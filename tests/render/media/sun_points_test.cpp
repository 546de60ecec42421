/// Light points of sunlight in media: their light is that of quadrature, and paths that use them
/// have the same expectation.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "clustered/media/media_render.h"
#include "clustered/media/sources/sun_points.h"
#include "fog_estimates.h"
#include "kinome/render_context.h"

namespace kinome::test::sun_points_test {
namespace {

constexpr double kAlpha = 1e-4;

std::string sun_xml(const std::string& direction, int irradiance = 2) {
  return "<emitter type=\"directional\"><vector name=\"direction\" value=\"" + direction +
         "\"/><rgb name=\"irradiance\" value=\"" + std::to_string(irradiance) + "\"/></emitter>";
}

/// Mean and variance of the mean of the sum of the light of all points at p, over draws.
Estimate light_of_points(const Scene& scene, const Vec3& p) {
  const Sensor& sensor = *scene.sensors().front();
  const transport::MediaTable media(scene, sensor);
  const transport::SceneTable table(scene, media.phases());
  RenderContext context({});
  const Emitter& sun = *scene.emitters().front();
  const Vec3 d = sun.sample_direct(Vec3(0.f), Vec2(0.5f))->d;
  const SunBeams beams(table, media, sensor, sun, d, 1, context);
  SunPoints points(table, media, beams, 256);
  RenderCounters counters;
  check::Moments moments;
  constexpr int kDraws = 100;
  for (int i = 0; i < kDraws; ++i) {
    points.draw(256, static_cast<uint64_t>(i), counters);
    double sum = 0;
    for (const uint32_t k : points.indices()) sum += points.light(k, p).weight.x;
    moments.add(sum / static_cast<double>(points.sets()));
  }
  return {moments.mean(), moments.variance_of_mean()};
}

void expect_near(const Estimate& found, double expected) {
  const double deviation = std::sqrt(found.variance_of_mean);
  EXPECT_NEAR(found.mean, expected, 4 * deviation + 1e-4 * expected);
  EXPECT_LT(deviation, 0.02 * expected);
}

/// Integral over the cube [-1,1]^n, n <= 3, by the midpoint rule.
double integral(int dimensions, const std::function<double(const Vec3&)>& f) {
  constexpr int kNodes = 48;
  const auto at = [](int i) { return -1 + (2 * static_cast<float>(i) + 1) / kNodes; };
  double sum = 0;
  for (int x = 0; x < kNodes; ++x) {
    for (int z = 0; z < kNodes; ++z) {
      for (int y = 0; y < (dimensions > 2 ? kNodes : 1); ++y) {
        sum += f(Vec3(at(x), dimensions > 2 ? at(y) : 0.f, at(z)));
      }
    }
  }
  return sum * std::pow(2. / kNodes, dimensions);
}

TEST(SunPoints, OnAFloorHaveTheLightOfQuadrature) {
  const auto scene = scene_from(
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"-90\"/>", diffuse_xml("0.6 0.6 0.6")) +
      sun_xml("0.6 -0.8 0") + integrator_xml("volpath", 3) +
      sensor_xml("perspective", look_at("0.5 1 4", "0 0 0", "0 1 0"), 8, 1));
  const Vec3 p(0.3f, 0.7f, -0.2f);
  const Estimate found = light_of_points(*scene, p);
  expect_near(found, integral(2, [&](const Vec3& y) {
                const double r2 = glm::dot(p - y, p - y);
                return 2 * 0.8 * 0.6 / kPi * (p.y / std::sqrt(r2)) / r2;
              }));
}

TEST(SunPoints, InACubeOfFogHaveTheLightOfQuadrature) {
  const auto scene =
      scene_from(fog_cube_xml(fog_xml("0.5 0.5 0.5", "0.8 0.8 0.8")) + sun_xml("0 -1 0") +
                 integrator_xml("volpath", 3) +
                 sensor_xml("perspective", look_at("0.5 1 4", "0 0 0", "0 1 0"), 8, 1));
  const Vec3 p(0.3f, 1.8f, -0.2f);
  const Estimate found = light_of_points(*scene, p);
  expect_near(found, integral(3, [&](const Vec3& y) {
                const double r2 = glm::dot(p - y, p - y);
                return 2 * 0.8 * 0.5 * std::exp(-0.5 * (1 - y.y)) / (4 * kPi) / r2;
              }));
}

/// A room of fog whose ceiling has a hole.
std::unique_ptr<Scene> room(const std::string& integrator, int size = 2, int samples = 128) {
  const auto wall = [](const std::string& transform) {
    return shape_xml("rectangle", transform,
                     "<bsdf type=\"twosided\">" + diffuse_xml("0.7 0.6 0.5") + "</bsdf>");
  };
  return scene_from(
      fog_cube_xml(fog_xml("0.4 0.4 0.4", "0.9 0.9 0.9", phase_xml(0.4f))) +
      wall("<scale value=\"1.1\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"-0.9\"/>") +
      wall("<scale value=\"1.1\"/><rotate x=\"1\" angle=\"90\"/><translate x=\"0.7\" y=\"0.9\"/>") +
      wall("<scale value=\"1.1\"/><translate z=\"-0.9\"/>") +
      wall("<scale value=\"1.1\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"-0.9\"/>") +
      sun_xml("0.4 -0.9 -0.1") + integrator +
      sensor_xml("perspective", look_at("0.5 0.2 4", "0 -0.1 0", "0 1 0"), size, samples));
}

/// FogBlock has the same expectation with light points and without.
TEST(SunPoints, DontChangeTheExpectation) {
  for (const int max_depth : {3, -1}) {
    const auto scene = room(integrator_xml("volpath", max_depth));
    Sensor& sensor = *scene->sensors().front();
    sensor.film().prepare(scene->integrator().layers());
    const transport::MediaTable media(*scene, sensor);
    const transport::SceneTable table(*scene, media.phases());
    RenderContext context({});
    FogSources with(*scene, context.scheduler);
    const FogSources without(*scene, context.scheduler);
    with.find_suns(table, media, 1e5, context);
    with.find_beams(table, media, sensor, 1e5, context);
    ASSERT_TRUE(with.beams());
    PathSettings settings;
    if (max_depth > 0) settings.length.max_depth = static_cast<uint32_t>(max_depth);
    const auto estimate = [&](const FogSources& sources, int blocks, uint64_t first_seed) {
      FogBlock block(table, media, sources, sensor, settings, 1);
      return radiance_of(block, blocks, first_seed);
    };
    const auto few = estimate(with, 48, 1), many = estimate(without, 192, 1000);
    expect_equal(few, many, kAlpha, "max_depth " + std::to_string(max_depth));
    EXPECT_LT(detectable_bias(few, many, kAlpha), 0.1);
  }
}

/// Variance of the mean of `samples` samples of a pixel, averaged over two pixels.
double variance_of_pixels(FogBlock& block, uint32_t samples) {
  constexpr int kSeeds = 48;
  constexpr size_t kPixels = 2;
  const uint32_t x[] = {0, 1}, y[] = {0, 1};
  std::array<check::Moments, kPixels> moments;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const PixelSamples all{x, y, kPixels, 0, samples, static_cast<uint64_t>(seed)};
    RenderCounters counters;
    block.trace(all, counters);
    for (size_t p = 0; p < kPixels; ++p) {
      double mean = 0;
      for (size_t k = 0; k < samples; ++k) {
        mean += mean_of(block.radiance().at(p * samples + k)) / samples;
      }
      moments[p].add(mean);
    }
  }
  double variance = 0;
  for (const check::Moments& m : moments) variance += m.variance_of_mean() * kSeeds / kPixels;
  return variance;
}

/// The error of a pixel falls in proportion to its samples, although they share rays of light.
TEST(SunPoints, TheErrorFallsWithTheNumberOfSamples) {
  const auto scene = room(integrator_xml("volpath", -1));
  Sensor& sensor = *scene->sensors().front();
  sensor.film().prepare(scene->integrator().layers());
  const transport::MediaTable media(*scene, sensor);
  const transport::SceneTable table(*scene, media.phases());
  RenderContext context({});
  FogSources sources(*scene, context.scheduler);
  sources.find_suns(table, media, 1e5, context);
  sources.find_beams(table, media, sensor, 1e5, context);
  ASSERT_TRUE(sources.beams());
  FogBlock block(table, media, sources, sensor, PathSettings(), 1);
  // The ratio is 128 if samples are independent. Both estimates are uncertain.
  EXPECT_GT(variance_of_pixels(block, 8), 64 * variance_of_pixels(block, 1024));
}

/// Threads render blocks in any order.
TEST(SunPoints, ABlockDoesNotDependOnThoseBefore) {
  constexpr uint32_t kSize = 64, kWidth = 16, kHeight = 8, kSamples = 16;
  constexpr uint32_t kColumns = kSize / kWidth, kBlocks = kColumns * kSize / kHeight;
  const auto scene = room(integrator_xml("volpath", 3), kSize, kSamples);
  Sensor& sensor = *scene->sensors().front();
  sensor.film().prepare(scene->integrator().layers());
  const transport::MediaTable media(*scene, sensor);
  const transport::SceneTable table(*scene, media.phases());
  RenderContext context({});
  FogSources sources(*scene, context.scheduler);
  sources.find_suns(table, media, kSize * kSize * kSamples, context);
  sources.find_beams(table, media, sensor, kSize * kSize * kSamples, context);
  ASSERT_TRUE(sources.beams());
  PathSettings settings;
  settings.length.max_depth = 3;
  FogBlock blocks[] = {{table, media, sources, sensor, settings, 1},
                       {table, media, sources, sensor, settings, 1}};
  std::vector<Rgb> radiance[2][kBlocks];
  for (int order = 0; order < 2; ++order) {
    for (uint32_t n = 0; n < kBlocks; ++n) {
      const uint32_t k = order == 0 ? n : kBlocks - 1 - n;
      uint32_t x[kWidth * kHeight], y[kWidth * kHeight];
      for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
        x[i] = k % kColumns * kWidth + i % kWidth, y[i] = k / kColumns * kHeight + i / kWidth;
      }
      const PixelSamples samples{x, y, kWidth * kHeight, 0, kSamples, 3};
      RenderCounters counters;
      blocks[order].trace(samples, counters);
      for (size_t i = 0; i < samples.count(); ++i) {
        radiance[order][k].push_back(blocks[order].radiance().at(i));
      }
    }
  }
  for (uint32_t k = 0; k < kBlocks; ++k) EXPECT_TRUE(radiance[0][k] == radiance[1][k]) << k;
}

/// Any order of the emitters gives the grids of the four strongest suns and the beams of the
/// strongest one.
TEST(SunPoints, AreThoseOfTheStrongestSunInAnyOrder) {
  std::vector<std::string> emitters{constant_xml("0.1 0.1 0.1")};
  for (const int irradiance : {1, 5, 2, 6, 4, 3}) {
    emitters.push_back(sun_xml("0." + std::to_string(irradiance) + " -1 0.2", irradiance));
  }
  const Vec3 p(0.3f, -0.4f, 0.2f);
  std::vector<float> lit;
  Vec3 origin(0.f);
  for (int order = 0; order < 7; ++order) {
    std::string xml = fog_cube_xml(fog_xml("0.5 0.5 0.5", "0.8 0.8 0.8"));
    for (const std::string& emitter : emitters) xml += emitter;
    const auto scene =
        scene_from(xml + integrator_xml("volpath", -1) +
                   sensor_xml("perspective", look_at("0.5 1 4", "0 0 0", "0 1 0"), 8, 1));
    std::rotate(emitters.begin(), emitters.begin() + 1, emitters.end());
    const Sensor& sensor = *scene->sensors().front();
    const transport::MediaTable media(*scene, sensor);
    const transport::SceneTable table(*scene, media.phases());
    RenderContext context({});
    FogSources sources(*scene, context.scheduler);
    sources.find_suns(table, media, 1e5, context);
    sources.find_beams(table, media, sensor, 1e5, context);
    ASSERT_EQ(sources.suns().size(), 4u);
    ASSERT_TRUE(sources.beams());
    EXPECT_EQ(&sources.beams()->emitter(), sources.distant().front().emitter);
    EXPECT_EQ(sources.beam_source(), 0u);
    std::vector<float> found;
    for (size_t s = 0; s < sources.suns().size(); ++s) {
      EXPECT_NEAR(sources.distant()[s].flux, 6 - static_cast<float>(s), 1e-5f);
      found.push_back(sources.suns()[s]->at(p));
    }
    float pdf = 0;
    uint32_t cell = 0;
    const Vec3 o = sources.beams()->sample(Vec2(0.3f, 0.7f), pdf, cell);
    if (order == 0) lit = found, origin = o;
    EXPECT_EQ(found, lit);
    EXPECT_EQ(o, origin);
  }
}

/// Sunlight is divided and its beams are learned only before a trial, and for FogBlock. `volpath`
/// renders some images of 50,000 samples and more without a trial.
TEST(SunPoints, AreLearnedOnlyIfTheyAreUsed) {
  struct Case {
    int size;
    uint32_t max_depth;
    bool has_trial, learns;
  };
  const uint32_t deep = PathSettings().length.max_depth;
  for (const Case& c : {Case{64, deep, true, false}, Case{64, deep, false, true},
                        Case{64, 3, true, true}, Case{80, deep, true, true}}) {
    const auto scene = room(integrator_xml("volpath", -1), c.size, 16);
    Sensor& sensor = *scene->sensors().front();
    sensor.film().prepare(scene->integrator().layers());
    RenderContext context({});
    PathSettings settings;
    settings.length.max_depth = c.max_depth;
    MediaRender render(*scene, sensor, settings, c.has_trial, context);
    render.choose(sensor);
    EXPECT_EQ(!render.sources().suns().empty(), c.learns) << c.size;
    EXPECT_EQ(render.sources().beams() != nullptr, c.learns) << c.size;
    EXPECT_TRUE(c.learns || render.choice().uses_paths);
  }
}

TEST(SunPoints, AreTheSameOnAnyNumberOfThreads) {
  const auto scene =
      room(integrator_xml("clustered", -1, "<boolean name=\"trial\" value=\"false\"/>"), 64, 16);
  EXPECT_EQ(render_scene(*scene, 3, 1).data, render_scene(*scene, 3, 2).data);
}

}  // namespace
}  // namespace kinome::test::sun_points_test

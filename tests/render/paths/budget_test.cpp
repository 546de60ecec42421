// Tests of budgets on real scenes. With any limit, the expectation is that of `direct`, and the
// reported error is correct. Each z-test has a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "render/direct/direct_scenes.h"

namespace kinome::test::budget_test {
namespace {

constexpr double kAlpha = 1e-4;

/// Shadows and a glossy lobe, under a sky with a sun of finite size.
std::unique_ptr<Scene> scene_of(const std::string& integrator, int width, int height, int samples,
                                const std::string& sampler = "sobol") {
  static const TemporaryFolder folder;
  const std::string light = envmap_xml(folder, 32, 17, [](int x, int y) {
    return x > 18 && x < 22 && y > 4 && y < 8 ? Rgb(30, 27, 20) : Rgb(.4f, .5f, .7f);
  });
  const std::string gloss = R"(<bsdf type="roughplastic"><float name="alpha" value=".2"/></bsdf>)";
  return scene_from(
      "<scene version=\"3.0.0\">" + integrator +
      R"(<sensor type="perspective"><float name="fov" value="45"/><transform name="to_world">
      <lookat origin="0,2,5" target="0,.4,0" up="0,1,0"/></transform><sampler type=")" +
      sampler + "\"><integer name=\"sample_count\" value=\"" + std::to_string(samples) +
      "\"/></sampler><film type=\"hdrfilm\"><integer name=\"width\" value=\"" +
      std::to_string(width) + "\"/><integer name=\"height\" value=\"" + std::to_string(height) +
      R"("/><rfilter type="box"/></film></sensor><shape type="sphere">
      <point name="center" x="-.7" y=".7" z="0"/><float name="radius" value=".7"/>)" +
      gloss + R"(</shape><shape type="cube"><transform name="to_world">
      <scale x=".3" y=".8" z=".3"/><translate x=".8" y=".8" z="0"/></transform>)" +
      diffuse_xml(".6 .5 .4") + R"(</shape><shape type="rectangle"><transform name="to_world">
      <scale value="5"/><rotate x="1" angle="-90"/></transform>)" +
      diffuse_xml(".5 .5 .5") + "</shape>" + light + "</scene>");
}
std::string product_xml(const std::string& parameters = "") {
  return R"(<integrator type="clustered"><integer name="max_depth" value="2"/>)" + parameters +
         "</integrator>";
}

struct Rendered {
  Image image;
  RenderStats stats;
};
Rendered render_with(const Scene& scene, const RenderBudget& budget, uint64_t seed,
                     unsigned threads = 1, uint64_t order = 0,
                     const std::atomic<bool>* cancel = nullptr,
                     ProgressCallback progress = nullptr) {
  RenderContext context({.threads = threads,
                         .seed = seed,
                         .cancel = cancel,
                         .progress = std::move(progress),
                         .tile_order_seed = order,
                         .budget = budget});
  Rendered result{render(scene, *scene.sensors()[0], context), {}};
  result.stats = context.job.stats();
  return result;
}

/// Returns relMSE as in RenderBudget::rel_mse, against an image that is nearly exact.
double rel_mse(const Image& image, const Image& truth) {
  double mean = 0, sum = 0;
  const auto values = static_cast<double>(truth.data.size());
  for (const float r : truth.data) mean += r / values;
  for (size_t i = 0; i < truth.data.size(); ++i) {
    const double r = truth.data[i], d = image.data[i] - r;
    sum += d * d / (r * r + 0.01 * mean * mean);
  }
  return sum / values;
}

/// Sums over tiles of 4x4 pixels, for renders with different seeds.
std::vector<Estimate> tiles_of(const std::function<Image(uint64_t)>& render, int renders) {
  std::vector<Moments> moments;
  for (int k = 1; k <= renders; ++k) {
    const Image image = render(static_cast<uint64_t>(k));
    const int across = image.width / 4, down = image.height / 4;
    std::vector<double> sums(static_cast<size_t>(across) * down * 3);
    for (int y = 0; y < down * 4; ++y) {
      for (int x = 0; x < across * 4; ++x) {
        for (int c = 0; c < 3; ++c) sums[(y / 4 * across + x / 4) * 3 + c] += image.at(x, y, c);
      }
    }
    moments.resize(sums.size());
    for (size_t i = 0; i < sums.size(); ++i) moments[i].add(sums[i]);
  }
  std::vector<Estimate> estimates;
  for (const Moments& m : moments) estimates.push_back({m.mean(), m.variance_of_mean()});
  return estimates;
}

const std::vector<Estimate>& direct_tiles() {
  static const std::vector<Estimate> tiles = [] {
    const auto scene = scene_of(direct_xml(), 16, 12, 64);
    return tiles_of([&](uint64_t seed) { return render_scene(*scene, 1000 + seed); }, kRenders);
  }();
  return tiles;
}

/// Passes in lanes. The number of samples is fixed, so that nothing depends on the results.
TEST(Budget, PassesAreUnbiased) {
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 16, 12, 32);
    const auto lanes = tiles_of(
        [&](uint64_t seed) {
          Image image = render_with(*scene, {.lanes = 4}, seed).image;
          EXPECT_EQ(image.channels.size(), 9u);
          return image;
        },
        kRenders);
    expect_equal(lanes, direct_tiles(), kAlpha, integrator);
  }
}

/// Several passes of different sizes, with a clock that counts rays.
TEST(Budget, TimedRendersAreUnbiased) {
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 16, 12, 32);
    double least = kInfinity;
    const auto timed = tiles_of(
        [&](uint64_t seed) {
          RenderStats* stats = nullptr;
          RenderContext context(
              {.threads = 1, .seed = seed, .budget = {.seconds = 0.02}, .clock = [&stats] {
                 const auto& rays = stats->counters.rays;
                 return 1e-6 * std::accumulate(rays.begin(), rays.end(), 0.);
               }});
          stats = &context.job.stats();
          Image image = render(*scene, *scene->sensors()[0], context);
          least = std::min(least, context.job.stats().samples);
          EXPECT_LE(context.job.seconds(), 0.022);
          return image;
        },
        kRenders);
    EXPECT_GT(least, 8) << "there is time for 20000 rays, 104 per pixel";
    expect_equal(timed, direct_tiles(), kAlpha, integrator);
  }
}

/// The number of passes depends on their results, which causes a bias. It is far below the noise,
/// so that these renders don't show it.
TEST(Budget, ErrorsBiasIsBelowTheNoise) {
  const auto scene = scene_of(product_xml(), 16, 12, 32);
  const auto adaptive = tiles_of(
      [&](uint64_t seed) { return render_with(*scene, {.rel_mse = 5e-3, .lanes = 4}, seed).image; },
      kRenders);
  expect_equal(adaptive, direct_tiles(), kAlpha, "error");
}

/// Compares the mean of the estimated errors of eight renders with that of their true errors. A
/// factor of 1.5 is more than 6 standard deviations, as measured (0.06 and 0.03 of the ratio).
TEST(Budget, ErrorMatchesItsEstimate) {
  const Image truth = render_scene(*scene_of(product_xml(), 32, 24, 1500), 999);
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 32, 24, 16);
    for (const double target : {1e-2, 1e-3}) {
      double reported = 0, actual = 0;
      for (uint64_t seed = 1; seed <= 8; ++seed) {
        const Rendered r = render_with(*scene, {.rel_mse = target}, seed);
        EXPECT_LE(r.stats.rel_mse, target);
        reported += r.stats.rel_mse;
        actual += rel_mse(r.image, truth);
      }
      EXPECT_LT(reported, 1.5 * actual) << integrator << " " << target;
      EXPECT_GT(reported, actual / 1.5) << integrator << " " << target;
    }
  }
}

TEST(Budget, SameBitsAtAnyThreadCountAndTileOrder) {
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 70, 40, 8);
    for (const RenderBudget& budget : {RenderBudget{.rel_mse = 5e-3}, RenderBudget{.lanes = 5}}) {
      const auto expected = render_with(*scene, budget, 3).image.data;
      EXPECT_EQ(render_with(*scene, budget, 3, 2, 5).image.data, expected) << integrator;
      EXPECT_EQ(render_with(*scene, budget, 3, 3, 0).image.data, expected) << integrator;
      EXPECT_NE(render_with(*scene, budget, 4).image.data, expected) << integrator;
    }
  }
}

/// The variance that lanes report equals that between seeds. The test is on the sum over the image,
/// with 64 renders and at least 64 x 7 degrees of freedom. A factor of 1.5 is more than 4 standard
/// deviations even if only 16 pixels mattered.
TEST(Budget, VarianceMatchesTheImage) {
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 16, 12, 32);
    std::vector<Moments> moments(16 * 12);
    double reported = 0;
    for (uint64_t seed = 1; seed <= kRenders; ++seed) {
      const Image image = render_with(*scene, {.lanes = 8}, seed).image;
      for (int i = 0; i < 16 * 12; ++i) {
        moments[i].add(image.at(i % 16, i / 16, 1));
        reported += image.at(i % 16, i / 16, 4) / kRenders;
      }
    }
    double actual = 0;
    for (const Moments& m : moments) actual += m.variance_of_mean() * kRenders;
    EXPECT_LT(reported, 1.5 * actual) << integrator;
    EXPECT_GT(reported, actual / 1.5) << integrator;
  }
}

/// Renders that are interrupted in the second round of passes or later are whole images of the
/// right brightness.
TEST(Budget, InterruptedRendersAreWhole) {
  // Progress reports the first round as a fifth of the whole, because the rest is unknown by then.
  constexpr double kFirstRound = 0.2 * (1 + 1e-9);
  const Image truth = render_scene(*scene_of(product_xml(), 48, 40, 64), 9);
  for (const std::string& integrator : {product_xml(), direct_xml()}) {
    const auto scene = scene_of(integrator, 48, 40, 16);
    for (const int tiles : {0, 1, 5}) {
      std::atomic<bool> cancel{false};
      int later = -1;  // tiles of the second round before this one
      const auto progress = [&](double share) {
        if (share > kFirstRound) ++later;
        if (later >= tiles) cancel = true;
      };
      // The first round has one sample per lane: with 16, no pixel is black by chance.
      const Rendered r =
          render_with(*scene, {.rel_mse = 1e-5, .lanes = 16}, 1, 1, 0, &cancel, progress);
      EXPECT_FALSE(r.stats.complete);
      double sum = 0, expected = 0;
      for (int i = 0; i < 48 * 40; ++i) {
        sum += r.image.at(i % 48, i / 48, 1);
        expected += truth.at(i % 48, i / 48, 1);
        const float value = r.image.at(i % 48, i / 48, 1);
        // Control terms may exceed the light that rays find in a dark pixel: the value is negative,
        // but rendered.
        EXPECT_TRUE(integrator == product_xml() ? value != 0 : value > 0) << integrator << " " << i;
      }
      EXPECT_NEAR(sum, expected, 0.1 * expected) << integrator;
    }
  }
}

TEST(Budget, DiagnosticsShowTheDistributionOfRays) {
  const auto scene = scene_of(product_xml(R"(<boolean name="diagnostics" value="true"/>
      <float name="rays_per_pixel" value="48"/>)"),
                              32, 24, 4);
  const Rendered r = render_with(*scene, {}, 1);
  ASSERT_EQ(r.image.channels,
            (std::vector<std::string>{"R", "G", "B", "samples", "cost", "visibility"}));
  double samples = 0, least = 1, most = 0;
  for (int i = 0; i < 32 * 24; ++i) {
    const int x = i % 32, y = i / 32;
    samples += r.image.at(x, y, 3);
    EXPECT_GE(r.image.at(x, y, 3), 2);
    EXPECT_GE(r.image.at(x, y, 4), r.image.at(x, y, 3));
    EXPECT_GE(r.image.at(x, y, 5), 0);
    EXPECT_LE(r.image.at(x, y, 5), 1);
    if (r.image.at(x, y, 4) == r.image.at(x, y, 3)) continue;  // the sky
    least = std::min<double>(least, r.image.at(x, y, 5));
    most = std::max<double>(most, r.image.at(x, y, 5));
  }
  // All camera rays except the pilot's 2 per pixel.
  EXPECT_EQ(samples + 2 * 32 * 24, r.stats.counters.rays[static_cast<int>(RayKind::kCamera)]);
  EXPECT_GT(most, 0.9);   // the open floor
  EXPECT_LT(least, 0.6);  // the floor that the cube hides
  EXPECT_EQ(render_with(*scene_of(product_xml(), 32, 24, 16), {}, 1).image.at(9, 9, 1),
            r.image.at(9, 9, 1));
  EXPECT_THROW(scene_of(product_xml(R"(<boolean name="diagnostics" value="true"/>
      <string name="importance" value="joint"/>)"),
                        8, 8, 4),
               Error);
}

}  // namespace
}  // namespace kinome::test::budget_test

// Tiles of an image that product sampling and `path` share.
#include "clustered/product/trial/method_map.h"

#include <gtest/gtest.h>

#include "clustered/product/pass/product_renderer.h"
#include "kinome/clustered_light.h"
#include "kit/statistics/statistics.h"
#include "product_scenes.h"
#include "seed_scenes.h"

namespace kinome::test::method_map_test {
namespace {

/// Returns one of two arbitrary addresses.
const Bsdf* bsdf_number(const int& number) { return reinterpret_cast<const Bsdf*>(&number); }

int tile_at(const TileGrid& grid, int x, int y) { return y * grid.tiles_x() + x; }

TEST(MethodMap, MaterialsHaveTheirMethods) {
  const TileGrid grid({0, 0, 160, 160});
  const int materials[2] = {};
  std::vector<MethodMap::Trial> trials;
  for (int i = 0; i < 64; ++i) {
    const bool is_odd = i % 2 == 1;
    trials.push_back({tile_at(grid, i % 8 * 5, i / 8 * 5), bsdf_number(materials[i % 2]),
                      is_odd ? 4. : 1., is_odd ? 1. : 4.});
  }
  const MethodMap map(grid, trials);
  EXPECT_EQ(map.path_work(), 64 * 2.25);  // square roots 1 and 2
  EXPECT_GT(map.product_work(), 64 * 2.25);
  EXPECT_EQ(map.mixed_work(), 64);
  for (const int x : {0, 12, 39}) {
    EXPECT_FALSE(map.is_for_path(tile_at(grid, x, x), bsdf_number(materials[0])));
    EXPECT_TRUE(map.is_for_path(tile_at(grid, x, x), bsdf_number(materials[1])));
  }
}

TEST(MethodMap, RegionsHaveTheirMethods) {
  const TileGrid grid({0, 0, 160, 160});
  std::vector<MethodMap::Trial> trials;
  for (int i = 0; i < 64; ++i) {
    const bool is_left = i % 8 < 4;
    trials.push_back({tile_at(grid, i % 8 * 5, i / 8 * 5), nullptr, is_left ? 9. : 1., 3.});
  }
  const MethodMap map(grid, trials);
  EXPECT_TRUE(map.is_for_path(tile_at(grid, 3, 20), nullptr));
  EXPECT_FALSE(map.is_for_path(tile_at(grid, 36, 20), nullptr));
  EXPECT_LT(map.mixed_work(), 0.8 * map.path_work());
}

/// An outlier adds the size of its square root to the standard error of the sum of square roots. It
/// doesn't decide for the image: path takes 64 times 2.
TEST(MethodMap, OutliersCountByTheirRoots) {
  const TileGrid grid({0, 0, 160, 160});
  std::vector<MethodMap::Trial> trials;
  for (int i = 0; i < 64; ++i) trials.push_back({i * 25, nullptr, i == 7 ? 100. : 1., 2.});
  EXPECT_NEAR(MethodMap(grid, trials).product_work(), 82. * 82 / 64, 1);
}

/// The measured work of a tile may be negative by chance.
TEST(MethodMap, NegativeWorkIsNone) {
  const TileGrid grid({0, 0, 160, 160});
  EXPECT_EQ(MethodMap(grid, {{0, nullptr, -4, -9}, {5, nullptr, 4, 4}}).path_work(), 2);
}

/// Returns the reason why `clustered` doesn't use product sampling; empty if it does.
std::string reason_for_path(const SeedScene& s) {
  const auto scene = scene_from(SeedSceneXml(s)("clustered", "", {64, 48}, 100));
  RenderContext context({.threads = 2});
  render(*scene, *scene->sensors().front(), context);
  for (const Skipped& skipped : context.job.stats().skipped) {
    if (skipped.what == "product") return skipped.why;
  }
  return {};
}

TEST(MethodChoice, LightThatFallsElsewhereIsLeftToPaths) {
  const std::string far = "most light doesn't reach what the camera sees";
  EXPECT_EQ(reason_for_path({"court", Subject::kCourt, Lamp::kSky, 1, 1000}), far);
  EXPECT_EQ(reason_for_path({"court", Subject::kCourt, Lamp::kPoint, 1000, 100}), far);
  EXPECT_NE(reason_for_path({"court", Subject::kCourt, Lamp::kSky, 1, 1}), far);
  EXPECT_NE(reason_for_path({"box", Subject::kBox, Lamp::kPanel, 1}), far);
}

TEST(MethodChoice, ShortRendersPrepareNothing) {
  const SeedScene court{"court", Subject::kCourt, Lamp::kSky, 1, 1};
  for (const int samples : {16, 400}) {
    const auto scene = scene_from(SeedSceneXml(court)("clustered", "", {64, 48}, samples));
    RenderContext context({.threads = 2});
    render(*scene, *scene->sensors().front(), context);
    EXPECT_EQ(context.job.stats().counters.stage_seconds.contains("cells"), samples > 16)
        << samples;
  }
}

/// Nearly all light of the court comes from the few points that the lamp lights.
TEST(MethodChoice, LightOfALampNearByIsSampled) {
  EXPECT_EQ(reason_for_path({"court", Subject::kCourt, Lamp::kPoint, 1}), "");
}

/// Renders an image whose left half is left to paths.
Image mixed(const Arrangement& s, uint64_t seed, int threads) {
  const auto scene = product_scene(s);
  const Sensor& sensor = *scene->sensors().front();
  RenderContext context({.threads = static_cast<unsigned>(threads), .seed = seed});
  ProductSettings settings;
  settings.rays_per_pixel = s.rays;
  settings.length.max_depth = static_cast<uint32_t>(s.max_depth);
  settings.hide_emitters = s.hide;
  sensor.film().prepare(scene->integrator().layers());
  const Emitter& sky = *scene->environment();
  auto cells =
      std::make_shared<const DistantCells>(sky, *cell_grid_of(sky), 128, context.scheduler);
  const ProductTask task(*scene, sensor, context, settings);
  const int last = task.grid.tiles_x() - 1;
  const std::vector<MethodMap::Trial> trials = {{0, nullptr, 2, 1}, {last, nullptr, 1, 2}};
  ProductRenderer renderer{task, std::move(cells), make_local_light(task)};
  renderer.use(std::make_unique<const MethodMap>(task.grid, trials), 0.2);
  renderer.render_all();
  return sensor.film().develop();
}

TEST(MethodMap, TilesOfBothMakeOneImage) {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .2)));
  s.max_depth = 3;
  s.rays = 40;
  s.direct_samples = 64;
  for (const char* const filter : {"box", "gaussian"}) {
    s.film = integer("width", 20) + integer("height", 12) + "<rfilter type=\"" + filter + "\"/>";
    constexpr int kRenders = 40;
    std::vector<Moments> moments(3 * 20 * 12);
    for (uint64_t seed = 1; seed <= kRenders; ++seed) {
      const Image image = mixed(s, seed, 2);
      ASSERT_EQ(image.data.size(), moments.size());
      for (size_t i = 0; i < moments.size(); ++i) moments[i].add(image.data[i]);
    }
    std::vector<Estimate> found;
    for (const Moments& m : moments) found.push_back({m.mean(), m.variance_of_mean()});
    expect_equal(found, estimate_pixels(*direct_scene(s), kRenders, 5000), kAlpha, filter);
  }
  EXPECT_EQ(mixed(s, 5, 1).data, mixed(s, 5, 3).data);
}

}  // namespace
}  // namespace kinome::test::method_map_test

// Tests that the size of blocks doesn't change results. Stages sort the samples of a block by
// material, emitter and direction, and must return the same bits for each sample in any block.

#include <gtest/gtest.h>

#include <cstring>

#include "support/render.h"
#include "transport/camera/camera.h"
#include "transport/light_paths/light_paths.h"
#include "transport/paths/paths.h"

namespace kinome::test::block_sizes_test {
namespace {

using namespace transport;

constexpr int kWidth = 32, kHeight = 16;
constexpr uint32_t kSamples = 16;

/// Returns a scene with several materials and emitters, one of which is a surface.
std::unique_ptr<Scene> balls() {
  return scene_from(R"(
    <sensor type="perspective">
      <transform name="to_world"><lookat origin="0 2 5" target="0 .7 0" up="0 1 0"/></transform>
      <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
      <film type="hdrfilm">
        <integer name="width" value="32"/><integer name="height" value="16"/>
      </film>
    </sensor>
    <emitter type="constant"/>
    <emitter type="point"><point name="position" value="0 2 1"/></emitter>
    <shape type="rectangle">
      <transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform>
      <bsdf type="roughplastic"/>
    </shape>
    <shape type="sphere"><point name="center" value="-1 1 0"/><bsdf type="conductor"/></shape>
    <shape type="sphere"><point name="center" value="1 1 0"/><bsdf type="roughconductor"/></shape>
    <shape type="rectangle">
      <transform name="to_world"><rotate x="1" angle="90"/><translate y="4"/></transform>
      <emitter type="area"/>
    </shape>)");
}

/// Calls fn(samples) for all pixels in blocks of `block` samples.
template <class Function>
void for_blocks(size_t block, const Function& fn) {
  std::vector<uint32_t> x, y;
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    x.push_back(i % kWidth), y.push_back(i / kWidth);
  }
  for (size_t first = 0; first < x.size(); first += block / kSamples) {
    const size_t pixels = std::min(block / kSamples, x.size() - first);
    fn(PixelSamples{x.data() + first, y.data() + first, pixels, 0, kSamples, 3});
  }
}

/// Returns the radiance of each sample: emission that the camera sees, plus the light that
/// `add(samples, seen, radiance, counters)` adds.
template <class Add>
std::vector<Rgb> radiance_by(const SceneTable& table, size_t block, const Add& add) {
  Camera camera(table, *table.scene().sensors()[0], block, false);
  Arena arena(block + kBlockLanes);
  const Columns3 radiance = arena.three();
  std::vector<Rgb> all;
  RenderCounters counters;
  for_blocks(block, [&](const PixelSamples& samples) {
    camera.trace(samples, counters);
    camera.set_seen_light(radiance);
    add(samples, camera.surfaces(), radiance, counters);
    for (size_t i = 0; i < samples.count(); ++i) all.push_back(radiance.at(i));
  });
  return all;
}

std::vector<Rgb> radiance_by_paths(const SceneTable& table, size_t block) {
  Paths paths(table, table.scene().sensors()[0]->sampler(), PathSettings(), block);
  return radiance_by(table, block,
                     [&](const PixelSamples& samples, const Surfaces& seen,
                         const Columns3& radiance, RenderCounters& counters) {
                       paths.add(samples, seen, {radiance, radiance}, counters);
                     });
}

std::vector<Rgb> radiance_by_direct_light(const SceneTable& table, size_t block) {
  DirectLight light(table, table.scene().sensors()[0]->sampler(), {1, 1}, block);
  return radiance_by(table, block,
                     [&](const PixelSamples& samples, const Surfaces& seen,
                         const Columns3& radiance, RenderCounters& counters) {
                       const Vertices vertices{&seen, seen.points().ray, {}};
                       light.sample(samples, vertices, 4, 4 + DirectLight::kDimensions);
                       light.add_emitter_samples(vertices, radiance, counters);
                       light.trace(vertices, Surfaces::Which::kEmitting, radiance, counters);
                     });
}

TEST(BlockSizes, ChangeNoPath) {
  const auto scene = balls();
  const SceneTable table(*scene);
  const std::vector<Rgb> expected = radiance_by_paths(table, 512);
  EXPECT_EQ(radiance_by_paths(table, 2048), expected);
  EXPECT_EQ(radiance_by_paths(table, 8192), expected);
}

TEST(BlockSizes, ChangeNoDirectLight) {
  const auto scene = balls();
  const SceneTable table(*scene);
  const std::vector<Rgb> expected = radiance_by_direct_light(table, 512);
  EXPECT_NE(expected, radiance_by(table, 512, [](const auto&...) {}));
  EXPECT_EQ(radiance_by_direct_light(table, 2048), expected);
  EXPECT_EQ(radiance_by_direct_light(table, 8192), expected);
}

/// Returns the sums that light paths add to the film.
std::vector<double> splats_by_light_paths(const SceneTable& table, size_t block) {
  const Sensor& sensor = *table.scene().sensors()[0];
  LightPaths paths(table, sensor, PathLength(), false, block);
  Film& film = sensor.film();
  film.prepare({{}});
  const Rect pixels{0, 0, kWidth, kHeight};
  FilmTile of_film = film.make_tile(pixels);
  RenderCounters counters;
  Tile tile{pixels, of_film, counters};
  for_blocks(block, [&](const PixelSamples& samples) { paths.trace(samples, tile); });
  film.commit(of_film);
  std::vector<double> sums;
  film.transfer([&](void* bytes, size_t count) {
    if (count != sizeof(double) * 3 * kWidth * kHeight) return;  // other data of the film
    sums.resize(count / sizeof(double));
    std::memcpy(sums.data(), bytes, count);
  });
  return sums;
}

/// The splats are the same for all block sizes, but the film adds them in the order of their
/// blocks. Its sums are in double precision, so only their last bits may differ. A wrong last bit
/// of a float would cause a difference that is a hundred million times larger.
TEST(BlockSizes, ChangeNoLightPath) {
  const auto scene = balls();
  const SceneTable table(*scene);
  const std::vector<double> expected = splats_by_light_paths(table, 512);
  ASSERT_EQ(expected.size(), size_t{3} * kWidth * kHeight);
  EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 0);
  for (const size_t block : {2048, 8192}) {
    const std::vector<double> sums = splats_by_light_paths(table, block);
    ASSERT_EQ(sums.size(), expected.size());
    for (size_t i = 0; i < sums.size(); ++i) {
      ASSERT_NEAR(sums[i], expected[i], 1e-13 * expected[i]) << block << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace kinome::test::block_sizes_test

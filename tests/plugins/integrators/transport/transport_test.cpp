// Tests the stages that integrators share.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "support/film_xml.h"
#include "support/render.h"
#include "transport/blocks/numbers.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"
#include "transport/shadows/direction_sort.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::test::transport_test {
namespace {

using namespace transport;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Returns `count` pseudorandom values in [0, 1) of this seed.
std::vector<float> random_numbers(size_t count, uint64_t seed) {
  std::vector<float> numbers;
  for (size_t i = 0; i < count; ++i) {
    numbers.push_back(to_unit_float(static_cast<uint32_t>(hash_words(seed, i))));
  }
  return numbers;
}

TEST(DirectionSort, OrdersRaysThatAreOn) {
  constexpr size_t kCount = 211;
  Arena arena(kCount);
  Ray16* const rays = arena.rays();
  const auto u = random_numbers(3 * kCount, 1);
  size_t on = 0;
  for (size_t i = 0; i < kCount; ++i) {
    Ray16& r = rays[i / 16];
    r.dx[i % 16] = u[3 * i] - 0.5f, r.dy[i % 16] = u[3 * i + 1] - 0.5f;
    r.dz[i % 16] = u[3 * i + 2] - 0.5f;
    r.ox[i % 16] = static_cast<float>(i);
    r.tmax[i % 16] = i % 5 == 0 ? -1.f : static_cast<float>(i);
    if (i % 5 != 0) ++on;
  }
  // An inactive ray may contain NaN.
  rays[0].dx[0] = kNaN;
  DirectionSort sort(kCount);
  ASSERT_EQ(sort.sort(rays, kCount), on);
  Arena to(kCount);
  Ray16* const sorted = to.rays();
  sort.copy(sorted, sizeof(Ray16));
  std::set<uint32_t> seen;
  for (size_t i = 0; i < on; ++i) {
    const uint32_t k = sort.order()[i];
    EXPECT_NE(k % 5, 0u);
    EXPECT_TRUE(seen.insert(k).second) << k;
    EXPECT_EQ(sorted[i / 16].ox[i % 16], static_cast<float>(k));
    EXPECT_EQ(sorted[i / 16].dy[i % 16], rays[k / 16].dy[k % 16]);
    EXPECT_EQ(sorted[i / 16].tmax[i % 16], static_cast<float>(k));
  }
  for (size_t i = on; i < padded(on); ++i) EXPECT_LT(sorted[i / 16].tmax[i % 16], 0.f);
}

/// A reflecting floor, an emitting shape that doesn't reflect, and a second floor of the first
/// one's material.
constexpr const char* kThreeShapes = R"(
  <integrator type="direct"/><sensor type="perspective"/>
  <bsdf type="diffuse" id="grey"/>
  <shape type="rectangle"><ref id="grey"/></shape>
  <shape type="rectangle">
    <transform name="to_world"><translate x="10"/></transform>
    <emitter type="area"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><translate x="20"/></transform><ref id="grey"/>
  </shape>)";

TEST(Surfaces, SortsHitsByMaterialInWholeVectors) {
  const auto scene = scene_from(kThreeShapes);
  const SceneTable table(*scene);
  ASSERT_EQ(table.rows().size(), 3u);
  EXPECT_EQ(table.reflecting(), 2u);
  constexpr size_t kCount = 60;
  Arena arena(kCount);
  RayHit16* const rays = arena.ray_hits();
  std::vector<float> place(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    Ray16& r = rays[i / 16].ray;
    const size_t lane = i % 16;
    // In turn: the first floor, the emitter, the second floor, nothing.
    place[i] = 10 * static_cast<float>(i % 4) + 0.01f * static_cast<float>(i);
    r.ox[lane] = place[i], r.oy[lane] = 0.25f, r.oz[lane] = 3, r.dz[lane] = -1;
    r.tmin[lane] = 0, r.tmax[lane] = kInfinity;
    rays[i / 16].shape[lane] = rays[i / 16].instance[lane] = kNoHit;
  }
  for (size_t i = kCount; i < padded(kCount); ++i) rays[i / 16].ray.tmax[i % 16] = -1;
  RenderCounters counters;
  scene->intersect(rays, padded(kCount) / 16, Coherence::kIncoherent, counters);
  for (const auto which : {Surfaces::Which::kAll, Surfaces::Which::kEmitting}) {
    Surfaces surfaces(table, kCount);
    surfaces.find(rays, kCount, which);
    const bool all = which == Surfaces::Which::kAll;
    ASSERT_EQ(surfaces.ranges().size(), all ? 3u : 1u);
    EXPECT_EQ(surfaces.reflecting(), all ? 32u : 0u);
    EXPECT_EQ(surfaces.live_reflecting(), all ? 30u : 0u);
    EXPECT_EQ(surfaces.missed().size(), 15u);
    for (const uint32_t ray : surfaces.missed()) EXPECT_EQ(ray % 4, 3u);
    std::set<uint32_t> seen;
    for (const Surfaces::Range& range : surfaces.ranges()) {
      EXPECT_EQ(range.first % kBlockLanes, 0u);
      for (size_t i = range.first; i < range.first + padded(range.count); ++i) {
        const bool is_point = i < range.first + range.count;
        EXPECT_EQ(surfaces.live()[i], is_point ? 1.f : 0.f);
        const uint32_t ray = surfaces.points().ray[i];
        ASSERT_LT(ray, kCount);
        EXPECT_EQ(surfaces.points().shape[i], range.row->shape);
        if (!is_point) continue;
        EXPECT_TRUE(seen.insert(ray).second);
        EXPECT_NEAR(surfaces.points().p.x[i], place[ray], 1e-5f);
        EXPECT_EQ(surfaces.points().dp_du.x[i], 2.f);
      }
    }
    EXPECT_EQ(seen.size(), all ? 45u : 15u);
  }
}

TEST(BucketCounts, CountOnlyUsedBuckets) {
  BucketCounts counts(1000000);
  for (const std::vector<uint32_t>& things :
       {std::vector<uint32_t>{7, 999999, 7, 0}, {}, {3, 2, 3, 7, 3}}) {
    counts.clear();
    std::map<uint32_t, uint32_t> expected;
    for (const uint32_t bucket : things) {
      counts.add(bucket);
      ++expected[bucket];
    }
    std::map<uint32_t, uint32_t> found;
    uint32_t last = 0;
    for (const uint32_t bucket : counts.used()) {
      EXPECT_GE(bucket, last);
      last = bucket;
      found[bucket] = std::exchange(counts[bucket], 12345);
    }
    EXPECT_EQ(found, expected);
  }
}

/// A column of 256 MB, of which 4 are used.
TEST(Arena, TakesTheMemoryThatIsUsed) {
  const auto resident = [] {
    std::ifstream file("/proc/self/statm");
    size_t pages = 0;
    file >> pages >> pages;
    return pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
  };
  [[maybe_unused]] const size_t before = resident();
  Arena arena(size_t{1} << 26);
  float* const column = arena.floats();
  EXPECT_EQ(reinterpret_cast<uintptr_t>(column) % kColumnAlignment, 0u);
  std::fill_n(column, size_t{1} << 20, 1.f);
  EXPECT_EQ(column[size_t{1} << 20], 0.f);
#ifndef KINOME_HAS_SANITIZER  // sanitizers keep additional data for all of it
  EXPECT_LT(resident(), before + (size_t{64} << 20));
#endif
}

/// Tests several threads, and arenas that other threads destroy.
TEST(Arena, ColumnsBeginAsZerosAndAreApart) {
  constexpr size_t kValues = 5000;
  std::vector<std::unique_ptr<Arena>> kept;
  std::mutex mutex;
  const auto use = [&](uint64_t seed) {
    for (uint64_t k = 0; k < 20; ++k) {
      auto arena = std::make_unique<Arena>(kValues + 100 * k);
      std::vector<float*> columns;
      for (int c = 0; c < 30; ++c) columns.push_back(arena->floats());
      for (size_t c = 0; c < columns.size(); ++c) {
        ASSERT_EQ(reinterpret_cast<uintptr_t>(columns[c]) % kColumnAlignment, 0u);
        for (size_t i = 0; i < arena->capacity(); ++i) ASSERT_EQ(columns[c][i], 0.f);
        std::fill_n(columns[c], arena->capacity(), static_cast<float>(c + 1));
      }
      for (size_t c = 0; c < columns.size(); ++c) {
        for (size_t i = 0; i < arena->capacity(); ++i) ASSERT_EQ(columns[c][i], c + 1);
      }
      const std::lock_guard lock(mutex);
      kept.push_back(std::move(arena));
      if (hash_words(seed, k) % 2 == 0) kept.erase(kept.begin());
    }
  };
  for (uint64_t round = 0; round < 3; ++round) {
    std::jthread other(use, 2 * round);
    use(2 * round + 1);
  }
}

TEST(Numbers, BelongToTheSample) {
  const auto sampler = make<Sampler>(
      "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"4\"/></sampler>");
  std::vector<uint32_t> x(64), y(64);
  for (uint32_t i = 0; i < 64; ++i) x[i] = 3 * i, y[i] = 100 - i;
  const PixelSamples samples{x.data(), y.data(), 64, 8, 4, 21};
  Numbers numbers(samples.count());
  Arena arena(samples.count());
  uint32_t* const owner = arena.indices();
  float* const one = arena.floats();
  const Columns2 two = arena.two();
  // Few values are computed one by one, and many as a block.
  for (const size_t count : {size_t{3}, size_t{200}}) {
    for (size_t i = 0; i < padded(count); ++i) owner[i] = static_cast<uint32_t>(37 * i % 256);
    numbers.fill_1d(*sampler, samples, 5, owner, count, one);
    numbers.fill_2d(*sampler, samples, 6, owner, count, two);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t pixel = owner[i] / 4;
      const SampleKey key{x[pixel], y[pixel], 8 + owner[i] % 4, 21};
      EXPECT_EQ(one[i], sampler->value_1d(key, 5));
      EXPECT_EQ(two.at(i), sampler->value_2d(key, 6));
    }
  }
}

/// Films with samples added by FilmTile::add and by FilmSamples.
struct Films {
  std::shared_ptr<Film> one_by_one, block;
};

/// Adds samples with `values` values, at least 3, to both films.
Films add_to_both(const std::string& filter, uint32_t samples, size_t values, float scale,
                  bool with_bad) {
  Films films{make_film(film_size(20, 12) + filter), make_film(film_size(20, 12) + filter)};
  std::vector<std::string> names;
  for (size_t k = 3; k < values; ++k) names.push_back("value " + std::to_string(k));
  for (const auto& film : {films.one_by_one, films.block}) film->prepare({names});
  const Rect pixels{3, 2, 11, 9};
  std::vector<uint32_t> x, y;
  for (int py = pixels.y0; py < pixels.y1; ++py) {
    for (int px = pixels.x0; px < pixels.x1; ++px) {
      x.push_back(static_cast<uint32_t>(px)), y.push_back(static_cast<uint32_t>(py));
    }
  }
  const PixelSamples block{x.data(), y.data(), x.size(), 0, samples, 1};
  const size_t count = block.count();
  Arena arena(count + kBlockLanes);
  const Columns2 position = arena.two();
  std::vector<float*> columns(values);
  for (float*& column : columns) column = arena.floats();
  const auto u = random_numbers((2 + values) * count, 9);
  FilmTile tile = films.one_by_one->make_tile(pixels);
  std::vector<float> of_sample(values);
  for (size_t i = 0; i < count; ++i) {
    const auto p = i / samples;
    const float* const of = &u[(2 + values) * i];
    position.set(i, film_position(static_cast<int>(x[p]), static_cast<int>(y[p]), {of[0], of[1]}));
    for (size_t k = 0; k < values; ++k) columns[k][i] = scale * of[2 + k];
    if (with_bad && i % 7 == 3) columns[i % values][i] = i % 2 ? kNaN : kInfinity;
    for (size_t k = 0; k < values; ++k) of_sample[k] = columns[k][i];
    tile.add(position.at(i), of_sample);
  }
  films.one_by_one->commit(tile);
  FilmTile other = films.block->make_tile(pixels);
  FilmSamples adder(films.block->filter(), static_cast<int>(values), count);
  // A common factor of all weights doesn't change the image.
  adder.add(block, position, columns, other, values > 3 ? 0.25f : 1.f);
  films.block->commit(other);
  EXPECT_EQ(tile.non_finite(), other.non_finite());
  return films;
}

void expect_same_image(const Films& films) {
  const Image a = films.one_by_one->develop(), b = films.block->develop();
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < static_cast<int>(a.channels.size()); ++c) {
        // A pixel's samples are summed in single precision, with weights that are off by
        // 2.5e-7 of the largest. A pixel may have only samples of small weights.
        const float sum = a.at(x, y, c);
        ASSERT_NEAR(b.at(x, y, c), sum, 2e-3f * sum) << x << " " << y << " " << c;
      }
    }
  }
  for (int c = 0; c < static_cast<int>(a.channels.size()); ++c) {
    EXPECT_NEAR(a.at(7, 5, c), b.at(7, 5, c), 3e-6f * a.at(7, 5, c));
  }
}

TEST(FilmSamples, AddsAsTheFilmDoes) {
  for (const char* filter :
       {"<rfilter type=\"box\"/>", "<rfilter type=\"tent\"/>", "<rfilter type=\"gaussian\"/>",
        "<rfilter type=\"tent\"><float name=\"radius\" value=\"1.4\"/></rfilter>",
        "<rfilter type=\"tent\"><float name=\"radius\" value=\"2.3\"/></rfilter>",
        "<rfilter type=\"tent\"><float name=\"radius\" value=\"3.4\"/></rfilter>",
        "<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"0.2\"/></rfilter>"}) {
    for (const size_t values : {3u, 4u, 5u, 15u, 17u, 194u}) {
      for (const uint32_t samples : {1u, 5u, 16u, 40u, 150u}) {
        if (samples * values > 1000) continue;  // takes long
        // Values whose sums need double precision are added one by one.
        for (const float scale : {1.f, 1e37f}) {
          for (const bool with_bad : {false, true}) {
            SCOPED_TRACE(testing::Message() << filter << " " << samples << " " << values << " "
                                            << scale << " " << with_bad);
            expect_same_image(add_to_both(filter, samples, values, scale, with_bad));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace kinome::test::transport_test

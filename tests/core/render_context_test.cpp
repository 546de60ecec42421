#include "kinome/render_context.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "kinome/sampler.h"
#include "support/render.h"

namespace kinome::test::render_context_test {
namespace {

std::shared_ptr<Film> make_film(const std::string& more = "") {
  return make<Film>(
      "<film type=\"hdrfilm\"><integer name=\"width\" value=\"150\"/>"
      "<integer name=\"height\" value=\"101\"/>" +
      more + "</film>");
}

/// Adds random values over many decades, so that sums depend on their order.
void random_tile(Tile& tile) {
  for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
    for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
      for (uint64_t s = 0; s < 3; ++s) {
        const auto number = [&](uint64_t d) {
          const uint64_t pixel = static_cast<uint64_t>(y) * 1000 + static_cast<uint64_t>(x);
          return to_unit_float(static_cast<uint32_t>(hash_words(pixel, s, d) >> 32));
        };
        const float v = std::exp(20 * number(2) - 10);
        tile.film.add(film_position(x, y, {number(0), number(1)}), std::vector<float>{v, 1 / v, 1});
        ++tile.counters[RayKind::kCamera];
      }
    }
  }
}

Image render_random(unsigned threads, uint64_t order, RenderStats* stats = nullptr) {
  const auto film = make_film();
  film->prepare({{}});
  RenderContext context({.threads = threads, .tile_order_seed = order});
  context.scheduler.for_each_tile(*film, random_tile);
  if (stats) *stats = context.job.stats();
  return film->develop();
}

TEST(RenderContext, SameBitsAtAnyThreadCountAndTileOrder) {
  const Image expected = render_random(1, 0);
  for (const unsigned threads : {1u, 2u, 3u, 8u}) {
    for (const uint64_t order : {0, 1, 2, 3}) {
      RenderStats stats;
      EXPECT_EQ(render_random(threads, order, &stats).data, expected.data)
          << threads << " threads, order " << order;
      EXPECT_EQ(stats.counters[RayKind::kCamera], 150u * 101u * 3u);
      EXPECT_GT(stats.first_tile_seconds, 0);
    }
  }
}

TEST(RenderContext, TileOrderIsShuffled) {
  const auto order = [](uint64_t seed) {
    const auto film = make_film();
    film->prepare({{}});
    std::vector<std::pair<int, int>> places;
    RenderContext context({.threads = 1, .tile_order_seed = seed});
    context.scheduler.for_each_tile(
        *film, [&](Tile& t) { places.emplace_back(t.pixels.x0, t.pixels.y0); });
    return places;
  };
  const auto plain = order(0);
  const auto shuffled = order(5);
  EXPECT_NE(plain, shuffled);
  EXPECT_EQ(std::set(plain.begin(), plain.end()), std::set(shuffled.begin(), shuffled.end()));
  EXPECT_EQ(plain.size(), 70u);
}

TEST(RenderContext, TilesCoverTheCropOnce) {
  for (const bool border : {false, true}) {
    const auto film = make_film(std::string("<integer name=\"crop_offset_x\" value=\"33\"/>"
                                            "<integer name=\"crop_width\" value=\"70\"/>"
                                            "<boolean name=\"sample_border\" value=\"") +
                                (border ? "true" : "false") + "\"/>");
    film->prepare({{}});
    std::mutex mutex;
    std::map<std::pair<int, int>, int> visits;
    RenderContext context({.threads = 3});
    context.scheduler.for_each_tile(*film, [&](Tile& tile) {
      EXPECT_LE(tile.pixels.width(), kSmallTileSize);
      EXPECT_LE(tile.pixels.height(), kSmallTileSize);
      const std::lock_guard lock(mutex);
      for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
        for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) ++visits[{x, y}];
      }
    });
    // The gaussian filter's radius is 2: samples up to 2 pixels outside reach a pixel's centre.
    const int grown = border ? 2 : 0;
    EXPECT_EQ(visits.size(), static_cast<size_t>((70 + 2 * grown) * (101 + 2 * grown)));
    EXPECT_EQ(visits.count({33 - grown, -grown}), 1u);
    for (const auto& [pixel, count] : visits) EXPECT_EQ(count, 1);
  }
}

TEST(RenderContext, CancelKeepsFinishedTiles) {
  for (const unsigned threads : {1u, 4u}) {
    for (const uint64_t order : {0, 9}) {
      const auto film = make_film("<rfilter type=\"box\"/>");
      film->prepare({{}});
      std::atomic<bool> cancel{false};
      std::atomic<int> begun{0};
      std::mutex mutex;
      std::vector<Rect> finished;
      RenderContext context({.threads = threads, .cancel = &cancel, .tile_order_seed = order});
      context.scheduler.for_each_tile(*film, [&](Tile& tile) {
        if (++begun >= 6) cancel = true;
        for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
          for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
            tile.film.add({x + 0.5f, y + 0.5f}, std::vector<float>{1, 1, 1});
          }
        }
        const std::lock_guard lock(mutex);
        finished.push_back(tile.pixels);
      });
      EXPECT_TRUE(context.job.cancelled());
      EXPECT_GE(finished.size(), 6u);
      EXPECT_LT(finished.size(), 6u + threads);
      int pixels = 0;
      for (const Rect& r : finished) pixels += r.area();
      float sum = 0;
      const Image image = film->develop();
      for (size_t i = 0; i < image.data.size(); i += 3) sum += image.data[i];
      EXPECT_EQ(sum, static_cast<float>(pixels));
    }
  }
}

TEST(RenderContext, ExceptionsPass) {
  for (const unsigned threads : {1u, 2u, 8u}) {
    const auto film = make_film();
    film->prepare({{}});
    RenderContext context({.threads = threads});
    std::atomic<int> calls{0};
    try {
      context.scheduler.for_each_tile(*film, [&](Tile& tile) {
        ++calls;
        if (tile.pixels.x0 == 32) throw Error("tile at " + std::to_string(tile.pixels.y0));
      });
      ADD_FAILURE() << "no exception";
    } catch (const Error& e) {
      EXPECT_STREQ(e.what(), "tile at 0");
    }
    EXPECT_LT(calls, 20);
    EXPECT_THROW(context.scheduler.parallel_for(1000,
                                                [](size_t i) {
                                                  if (i == 500) throw std::runtime_error("index");
                                                }),
                 std::runtime_error);
  }
}

TEST(RenderContext, ForEachVisitsEachIndexOnce) {
  for (const unsigned threads : {1u, 3u}) {
    for (const uint64_t order : {0, 5}) {
      for (const size_t count : {0u, 1u, 2u, 1000u}) {
        RenderContext context({.threads = threads, .tile_order_seed = order});
        std::vector<std::atomic<int>> visits(count);
        context.scheduler.for_each(count, [&](size_t i, RenderCounters& counters) {
          ++visits.at(i);
          ++counters[RayKind::kShadow];
          counters.stage_seconds["stage"] += 1;
        });
        for (const auto& v : visits) EXPECT_EQ(v, 1);
        EXPECT_EQ(context.job.stats().counters[RayKind::kShadow], count);
        if (count > 0) {
          EXPECT_EQ(context.job.stats().counters.stage_seconds["stage"],
                    static_cast<double>(count));
        }
      }
    }
  }
}

TEST(RenderContext, ForEachStopsAtExceptionsAndWhenCancelled) {
  for (const unsigned threads : {1u, 3u}) {
    std::atomic<int> done{0};
    RenderContext throwing({.threads = threads});
    EXPECT_THROW(throwing.scheduler.for_each(100000,
                                             [&](size_t i, RenderCounters&) {
                                               if (i == 10) throw std::runtime_error("ten");
                                               ++done;
                                             }),
                 std::runtime_error);
    EXPECT_LT(done, 99999);
    // The context is usable after the exception.
    done = 0;
    throwing.scheduler.for_each(20, [&](size_t, RenderCounters&) { ++done; });
    EXPECT_EQ(done, 20);

    std::atomic<bool> cancel{false};
    RenderContext cancelled({.threads = threads, .cancel = &cancel});
    done = 0;
    // The thread that finds 7 done cancels before it takes another index. Each other thread may
    // finish at most one more, however long it is suspended.
    cancelled.scheduler.for_each(100000, [&](size_t, RenderCounters&) {
      if (++done >= 7) cancel = true;
    });
    EXPECT_GE(done, 7);
    EXPECT_LE(done, 6 + static_cast<int>(threads));
    const int before = done;
    cancelled.scheduler.for_each(10, [&](size_t, RenderCounters&) { ++done; });
    EXPECT_EQ(done, before);
  }
}

TEST(RenderContext, ProgressOfParts) {
  std::vector<double> progress;
  RenderContext context(
      {.threads = 1, .progress = [&](double share) { progress.push_back(share); }});
  context.job.set_progress_range(0.2, 0.6);
  context.scheduler.for_each(50, [](size_t, RenderCounters&) {});
  context.job.set_progress_range(0.6, 1);
  context.scheduler.for_each(50, [](size_t, RenderCounters&) {});
  ASSERT_FALSE(progress.empty());
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  EXPECT_GE(progress.front(), 0.2);
  EXPECT_LE(progress.back(), 1);
}

TEST(RenderContext, ParallelForVisitsEachIndexOnce) {
  for (const unsigned threads : {1u, 2u, 8u}) {
    const RenderContext context({.threads = threads});
    for (const size_t count : {size_t{0}, size_t{1}, size_t{7}, size_t{100000}}) {
      std::vector<std::atomic<int>> visits(count);
      context.scheduler.parallel_for(count, [&](size_t i) { ++visits[i]; });
      for (const auto& v : visits) ASSERT_EQ(v, 1);
    }
  }
}

TEST(RenderContext, ThreadsServeOneCallAfterAnother) {
  const RenderContext context({.threads = 4});
  std::mutex mutex;
  std::set<std::thread::id> threads;
  for (size_t count = 0; count < 300; ++count) {
    std::atomic<size_t> visits{0};
    context.scheduler.parallel_for(count, [&](size_t) {
      ++visits;
      const std::lock_guard lock(mutex);
      threads.insert(std::this_thread::get_id());
    });
    ASSERT_EQ(visits, count);
  }
  EXPECT_LE(threads.size(), 4u);
}

/// The nested call runs on the thread of its item, because all others may be inside one, too.
TEST(RenderContext, ParallelForWithinOne) {
  const RenderContext context({.threads = 3});
  std::vector<std::atomic<int>> visits(60 * 50);
  context.scheduler.parallel_for(60, [&](size_t i) {
    const auto thread = std::this_thread::get_id();
    context.scheduler.parallel_for(50, [&](size_t k) {
      EXPECT_EQ(std::this_thread::get_id(), thread);
      ++visits[50 * i + k];
    });
  });
  for (const auto& v : visits) EXPECT_EQ(v, 1);
}

TEST(RenderContext, ProgressRisesToOne) {
  const auto film = make_film();
  film->prepare({{}});
  std::vector<double> progress;
  std::atomic<int> inside{0};
  RenderContext context({.threads = 8, .progress = [&](double fraction) {
                           EXPECT_EQ(++inside, 1) << "two threads at once";
                           progress.push_back(fraction);
                           --inside;
                         }});
  context.scheduler.for_each_tile(*film, [](Tile&) {});
  ASSERT_FALSE(progress.empty());
  for (size_t i = 1; i < progress.size(); ++i) EXPECT_GT(progress[i], progress[i - 1]);
  EXPECT_EQ(progress.back(), 1);
}

#if defined(__SSE2__)
TEST(RenderContext, DenormalsAreFlushedInEveryThreadAndOnlyThere) {
  const auto is_flushed = [] {
    volatile float tiny = std::numeric_limits<float>::min();
    return tiny * 0.5f == 0;
  };
  EXPECT_FALSE(is_flushed());
  const auto film = make_film();
  film->prepare({{}});
  RenderContext context({.threads = 4});
  std::mutex mutex;
  std::set<std::thread::id> threads;
  context.scheduler.for_each_tile(*film, [&](Tile&) {
    EXPECT_TRUE(is_flushed());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_GT(threads.size(), 1u);
  context.scheduler.parallel_for(64, [&](size_t) { EXPECT_TRUE(is_flushed()); });
  EXPECT_FALSE(is_flushed());
}
#endif

TEST(RenderContext, SkippedWorkIsNotedOnce) {
  RenderContext context({.threads = 1});
  context.job.skip("light tree", "no light points");
  context.job.skip("light tree", "no light points");
  context.job.skip("lobe rays", "all surfaces are diffuse");
  EXPECT_EQ(context.job.stats().skipped.size(), 2u);
}

class CountingIntegrator : public Integrator {
 public:
  std::vector<std::vector<std::string>> layers() const override { return {{"index"}, {"second"}}; }
  void render(const Scene&, const Sensor& sensor, RenderContext& context) const override {
    const auto add = [](Tile& tile, const std::vector<float>& values) {
      for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
        for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
          tile.film.add({x + 0.5f, y + 0.5f}, values);
        }
      }
    };
    context.scheduler.for_each_tile(sensor.film(), [&](Tile& t) { add(t, {1, 2, 3, 4}); });
    context.scheduler.for_each_tile(
        sensor.film(), [&](Tile& t) { add(t, {5}); }, 1);
    context.scheduler.for_each_tile(
        sensor.film(), [&](Tile& t) { add(t, {kInfinity}); }, 1);
  }
};

TEST(Render, PreparesDevelopsAndFillsStats) {
  Scene::Contents contents;
  contents.integrator = std::make_shared<CountingIntegrator>();
  contents.sensors = {make<Sensor>(
      "<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"40\"/>"
      "<integer name=\"height\" value=\"8\"/></film></sensor>")};
  const Scene scene(contents, 1);
  RenderContext context({.threads = 2});
  for (int run = 0; run < 2; ++run) {
    const Image image = render(scene, *scene.sensors()[0], context);
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "index", "second"}));
    for (int c = 0; c < 5; ++c) EXPECT_NEAR(image.at(20, 4, c), c + 1.f, 1e-5f);
  }
  const RenderStats& stats = context.job.stats();
  EXPECT_EQ(stats.threads, 2u);
  EXPECT_GT(stats.render_seconds, 0);
  EXPECT_GT(stats.peak_memory_bytes, 1u << 20);
  EXPECT_EQ(stats.non_finite_samples, 2u * 320u);
  EXPECT_TRUE(stats.complete);
}

TEST(Stats, CountersAdd) {
  RenderCounters a;
  RenderCounters b;
  a[RayKind::kShadow] = 3;
  b[RayKind::kShadow] = 4;
  b[RayKind::kLobe] = 1;
  a.stage_seconds["shade"] = 1;
  b.stage_seconds["shade"] = 2;
  b.stage_seconds["trace"] = 5;
  b.embree_seconds = 0.5;
  b.skipped_shadow_rays = 9;
  a.add(b);
  EXPECT_EQ(a[RayKind::kShadow], 7u);
  EXPECT_EQ(a[RayKind::kLobe], 1u);
  EXPECT_EQ(a.stage_seconds, (std::map<std::string, double>{{"shade", 3}, {"trace", 5}}));
  EXPECT_EQ(a.embree_seconds, 0.5);
  EXPECT_EQ(a.skipped_shadow_rays, 9u);
  EXPECT_STREQ(to_string(RayKind::kBsdf), "bsdf");
}

}  // namespace
}  // namespace kinome::test::render_context_test

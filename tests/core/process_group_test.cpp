// Tests groups of processes, with threads in place of processes. All results must have the bits of
// a single process.
#include "kinome/process_group.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "kinome/checkpoint.h"
#include "kinome/render.h"
#include "kinome/shared_items.h"
#include "support/render.h"
#include "support/thread_group.h"

#ifdef __SANITIZE_THREAD__
// glibc reuses the memory of thread-local variables of threads that end, under an internal lock
// that the sanitizer doesn't know.
extern "C" KINOME_EXPORT const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:_dl_deallocate_tls";
}
#endif

namespace kinome::test::process_group_test {
namespace {

using std::chrono::microseconds;

/// Waits for a pseudorandom time, so that the assignment of items to processes is unpredictable.
void dawdle(size_t item) {
  std::this_thread::sleep_for(microseconds(hash_words(item) % 300));
}

std::shared_ptr<Film> make_film() {
  auto film = make<Film>(
      "<film type=\"hdrfilm\"><integer name=\"width\" value=\"150\"/>"
      "<integer name=\"height\" value=\"101\"/></film>");
  film->prepare({{}});
  return film;
}

/// Adds values over many decades, at positions that reach into neighbouring tiles, and splats at
/// random positions.
void add_samples(FilmTile& tile) {
  const Rect& pixels = tile.pixels();
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      const auto number = [&](uint64_t d) {
        const auto pixel = static_cast<uint64_t>(y * 1000 + x);
        return to_unit_float(static_cast<uint32_t>(hash_words(pixel, d) >> 32));
      };
      const float v = std::exp(20 * number(2) - 10);
      tile.add(film_position(x, y, {number(0), number(1)}), std::vector<float>{v, 1 / v, 1});
      tile.add_splat({150 * number(3), 101 * number(4)}, Rgb(v));
    }
  }
  tile.add_light_paths(pixels.area());
}

std::vector<float> render_tiles(RenderContext& context, Film& film) {
  context.scheduler.set_film(film);
  context.scheduler.for_each_tile(film, [](Tile& tile) {
    dawdle(static_cast<size_t>(tile.pixels.x0 + tile.pixels.y0));
    add_samples(tile.film);
    ++tile.counters[RayKind::kCamera];
  });
  return film.develop().data;
}

TEST(ProcessGroup, TilesHaveTheSameBits) {
  std::vector<float> alone;
  {
    const auto film = make_film();
    RenderContext context({.threads = 1});
    alone = render_tiles(context, *film);
  }
  for (const int size : {1, 2, 5}) {
    ThreadGroups::run(size, [&](ProcessGroup& group) {
      const auto film = make_film();
      RenderContext context({.threads = 2, .group = &group});
      EXPECT_EQ(context.scheduler.all_threads(), 2u * static_cast<unsigned>(size));
      const std::vector<float> together = render_tiles(context, *film);
      if (group.is_root()) {
        EXPECT_EQ(together, alone) << size;
      }
      // All processes have the counters of the whole group.
      EXPECT_EQ(context.job.stats().counters[RayKind::kCamera], 10u * 7u);
    });
  }
}

TEST(ProcessGroup, SharedItemsReachAllProcesses) {
  constexpr size_t kItems = 40;
  ThreadGroups::run(3, [&](ProcessGroup& group) {
    RenderContext context({.threads = 2, .group = &group});
    std::vector<std::vector<float>> found(kItems);
    std::vector<int> kept(kItems, -1);
    SharedItems first([&](size_t item, SharedBytes& bytes) { bytes.vector(found[item]); });
    context.scheduler.for_each(
        kItems,
        [&](size_t item, RenderCounters&) {
          dawdle(item);
          found[item].assign(item % 4, static_cast<float>(item));
          kept[item] = group.rank();
        },
        &first);
    for (size_t item = 0; item < kItems; ++item) {
      EXPECT_EQ(found[item], std::vector<float>(item % 4, static_cast<float>(item)));
    }
    // The process that computed an item continues with it.
    std::vector<int> planned(kItems, -1);
    SharedItems second([&](size_t item, SharedBytes& bytes) { bytes.value(planned[item]); });
    second.assign(first.ranks());
    context.scheduler.for_each(
        kItems, [&](size_t item, RenderCounters&) { planned[item] = kept[item]; }, &second);
    EXPECT_EQ(planned, first.ranks());
    EXPECT_EQ(second.ranks(), first.ranks());
  });
}

TEST(ProcessGroup, AllAgree) {
  ThreadGroups::run(3, [&](ProcessGroup& group) {
    RenderContext context({.threads = 1, .group = &group});
    EXPECT_EQ(agree(context.job.group(), 10 + group.rank()), 10);
    EXPECT_EQ(context.job.decide([&] { return 20. + group.rank(); }), 20);
    uint64_t sums[] = {1, static_cast<uint64_t>(group.rank())};
    sum_over_processes(context.job.group(), sums);
    EXPECT_EQ(sums[0], 3u);
    EXPECT_EQ(sums[1], 3u);
  });
}

TEST(ProcessGroup, AnErrorOfOneProcessEndsAll) {
  ThreadGroups::run(3, [&](ProcessGroup& group) {
    RenderContext context({.threads = 1, .group = &group});
    try {
      context.scheduler.for_each(30, [&](size_t item, RenderCounters&) {
        dawdle(item);
        if (item == 7) throw std::runtime_error("item 7");
      });
      ADD_FAILURE() << "rank " << group.rank();
    } catch (const AgreedError& error) {
      EXPECT_STREQ(error.what(), "item 7");
    }
    // The group can continue after the error.
    EXPECT_EQ(agree(context.job.group(), group.rank()), 0);
    const auto fails_at_one = [&] {
      if (group.rank() == 1) throw Error("no such file");
    };
    try {
      on_all_processes(&group, fails_at_one);
      ADD_FAILURE() << "rank " << group.rank();
    } catch (const AgreedError& error) {
      EXPECT_STREQ(error.what(), "rank 1 on here: no such file");
    }
  });
}

TEST(ProcessGroup, OneInterruptEndsAll) {
  std::atomic<size_t> made{0};
  ThreadGroups::run(3, [&](ProcessGroup& group) {
    std::atomic<bool> cancel{false};
    RenderContext context({.threads = 1, .cancel = &cancel, .group = &group});
    context.scheduler.for_each(10000, [&](size_t item, RenderCounters&) {
      dawdle(item);
      if (++made >= 30 && group.rank() == 2) cancel = true;
    });
    EXPECT_TRUE(context.job.interrupted());
    EXPECT_TRUE(context.job.cancelled());
  });
  EXPECT_LT(made, 10000u);
}

TEST(ProcessGroup, OneDeadlineEndsAll) {
  ThreadGroups::run(2, [&](ProcessGroup& group) {
    RenderContext context({.threads = 1, .group = &group});
    context.job.set_deadline(group.rank() == 1 ? 0 : kInfinity);
    context.scheduler.for_each(10000, [&](size_t item, RenderCounters&) { dawdle(item); });
    EXPECT_TRUE(context.job.cancelled());
    EXPECT_FALSE(context.job.interrupted());
    context.job.set_deadline(kInfinity);
    EXPECT_FALSE(context.job.cancelled());
  });
}

/// `clustered` learns first: it can't use `path`, which misses the lamp's light in the mirror. The
/// addresses of its tables, nested materials and bumps differ between processes.
constexpr const char* kScene = R"(
  <integrator type="clustered"/>
  <sensor type="perspective">
    <transform name="to_world"> <lookat origin="0.3,1.1,5" target="0,0,0" up="0,1,0"/> </transform>
    <sampler type="independent"> <integer name="sample_count" value="12"/> </sampler>
    <film type="hdrfilm"> <integer name="width" value="72"/> <integer name="height" value="40"/>
      <string name="component_format" value="float32"/> </film>
  </sensor>
  <emitter type="constant"/>
  <emitter type="point"> <point name="position" x="1" y="3" z="3"/> </emitter>
  <shape type="sphere"> <bsdf type="roughplastic"/> </shape>
  <shape type="sphere"> <point name="center" x="-1.3" y="-0.7" z="1"/>
    <float name="radius" value="0.3"/> <bsdf type="conductor"/> </shape>
  <shape type="sphere"> <point name="center" x="1.7" y="0" z="0.5"/>
    <bsdf type="blendbsdf"> <float name="weight" value="0.4"/>
      <bsdf type="roughplastic"> <float name="alpha" value="0.3"/> </bsdf>
      <bsdf type="diffuse"/> </bsdf> </shape>
  <shape type="rectangle">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="9"/>
      <translate y="-1"/> </transform>
    <bsdf type="roughconductor"> <float name="alpha" value="0.05"/> </bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"> <scale value="0.3"/> <translate x="-1" y="1.5" z="1"/> </transform>
    <emitter type="area"> <rgb name="radiance" value="9"/> </emitter>
  </shape>)";

TEST(ProcessGroup, LearnedDataGiveTheSameBits) {
  const std::vector<float> alone = render_scene(*scene_from(kScene)).data;
  for (const int size : {2, 3}) {
    std::vector<std::unique_ptr<Scene>> scenes;
    for (int i = 0; i < size; ++i) scenes.push_back(scene_from(kScene));
    ThreadGroups::run(size, [&](ProcessGroup& group) {
      const Scene& scene = *scenes[static_cast<size_t>(group.rank())];
      RenderContext context({.threads = 2, .group = &group});
      const Image image = render(scene, *scene.sensors()[0], context);
      if (group.is_root()) {
        EXPECT_EQ(image.data, alone) << size;
      }
      EXPECT_GT(context.job.stats().traffic["ends"].messages, 0u);
    });
  }
}

TEST(ProcessGroup, CheckpointsDoNotDependOnIt) {
  const TemporaryFolder folder;
  std::vector<float> alone;
  {
    const auto film = make_film();
    RenderContext context({.threads = 1});
    alone = render_tiles(context, *film);
  }
  const std::string path = folder.path("kept");
  std::atomic<int> made_again{0};
  for (const int size : {3, 2}) {
    const bool is_first = size == 3;
    ThreadGroups::run(size, [&](ProcessGroup& group) {
      const auto film = make_film();
      std::atomic<bool> cancel{false};
      std::atomic<int> made{0};
      RenderContext context({.threads = 1, .cancel = &cancel, .group = &group});
      std::optional<Checkpoint> checkpoint;
      if (group.is_root()) {
        checkpoint.emplace(Checkpoint::Options{path, 0, !is_first});
        checkpoint->begin(*film);
        context.job.set_work_source(&*checkpoint);
      }
      context.scheduler.set_film(*film);
      context.scheduler.for_each_tile(*film, [&](Tile& tile) {
        dawdle(static_cast<size_t>(tile.pixels.x0 + tile.pixels.y0));
        add_samples(tile.film);
        if (++made == 2) cancel = is_first;
        if (!is_first) ++made_again;
      });
      EXPECT_EQ(context.job.interrupted(), is_first);
      if (group.is_root() && !is_first) {
        EXPECT_EQ(film->develop().data, alone);
      }
    });
  }
  // In the first run, some process has finished two tiles.
  EXPECT_GT(made_again, 0);
  EXPECT_LE(made_again, 68);
}

}  // namespace
}  // namespace kinome::test::process_group_test

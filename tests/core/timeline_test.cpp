// Timelines: which thread worked when.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "kinome/render_context.h"
#include "kinome/stage_threads.h"
#include "kinome/timeline.h"
#include "support/render.h"

namespace kinome::test::timeline_test {
namespace {

using namespace std::chrono_literals;

void work(std::chrono::milliseconds time) {
  std::this_thread::sleep_for(time);
}

const StageThreads& stage_of(const std::vector<StageThreads>& stages, const std::string& name) {
  const auto found = std::find_if(stages.begin(), stages.end(),
                                  [&](const StageThreads& stage) { return stage.stage == name; });
  if (found == stages.end()) throw std::runtime_error("no stage " + name);
  return *found;
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.);
}

/// Runs a serial stage around a setup loop, a loop of one stage and a loop of two.
void run_stages(RenderContext& context) {
  {
    const StageTimer timer(context.job.stats().counters.stage_seconds["cells"]);
    context.scheduler.parallel_for(4, [](size_t) { work(2ms); });
  }
  context.scheduler.for_each(7, [](size_t, RenderCounters& counters) {
    const StageTimer timer(counters.stage_seconds["pilot"]);
    work(3ms);
  });
  context.scheduler.for_each(4, [&](size_t, RenderCounters& counters) {
    // A loop within an item isn't recorded.
    context.scheduler.parallel_for(3, [](size_t) {});
    counters.stage_seconds["primary"] += 1;
    counters.stage_seconds["shade"] += 1;
  });
}

TEST(Timeline, PartsFollowEachOtherAndHaveStages) {
  Timeline timeline(Timeline::Clock::now());
  RenderContext context({.threads = 2, .timeline = &timeline});
  run_stages(context);
  timeline.end_serial("write");
  std::vector<std::string> stages;
  double time = 0;
  for (const Timeline::Part& part : timeline.parts()) {
    if (stages.empty() || stages.back() != part.stage) stages.push_back(part.stage);
    EXPECT_EQ(part.begin, time);
    EXPECT_GE(part.end, part.begin);
    time = part.end;
  }
  EXPECT_EQ(stages.front(), "cells");
  const auto place = [&](const char* stage) {
    return std::find(stages.begin(), stages.end(), stage) - stages.begin();
  };
  EXPECT_LT(place("cells"), place("pilot"));
  EXPECT_LT(place("pilot"), place("tiles"));
  EXPECT_EQ(stages.back(), "write");
}

TEST(Timeline, ALoopNamesThePreparationsWithoutAStage) {
  Timeline timeline(Timeline::Clock::now());
  RenderContext context({.threads = 2, .timeline = &timeline});
  timeline.end_serial("load");
  context.scheduler.parallel_for(4, [](size_t) {});
  context.scheduler.for_each(2, [](size_t, RenderCounters& counters) {
    counters.stage_seconds["primary"] += 1;
    counters.stage_seconds["shade"] += 1;
  });
  timeline.end_serial("develop");
  std::vector<std::string> stages;
  for (const Timeline::Part& part : timeline.parts()) stages.push_back(part.stage);
  EXPECT_EQ(stages, (std::vector<std::string>{"load", "tiles", "tiles", "tiles", "tiles", "develop"}));
}

TEST(Timeline, EventsOfAThreadDontOverlapAndCoverAllItems) {
  for (const unsigned threads : {1u, 2u, 5u}) {
    Timeline timeline(Timeline::Clock::now());
    RenderContext context({.threads = threads, .timeline = &timeline});
    run_stages(context);
    EXPECT_LE(timeline.events().size(), threads);
    size_t pilots = 0;
    for (const auto& events : timeline.events()) {
      double time = 0;
      for (const Timeline::Event& event : events) {
        const Timeline::Part& part = timeline.parts().at(event.part);
        EXPECT_GE(event.begin, time);
        EXPECT_GE(event.end, event.begin);
        EXPECT_GE(event.begin, part.begin);
        EXPECT_LE(event.end, part.end);
        time = event.end;
        pilots += part.stage == "pilot";
      }
    }
    // The serial part before the loop may have this stage, too.
    EXPECT_GE(pilots, 7u);
  }
}

TEST(Timeline, IdleTimeOfALastItemIsReported) {
  Timeline timeline(Timeline::Clock::now());
  RenderContext context({.threads = 2, .timeline = &timeline});
  context.scheduler.for_each(1, [](size_t, RenderCounters& counters) {
    const StageTimer timer(counters.stage_seconds["pilot"]);
    work(20ms);
  });
  const auto stages = stage_threads(timeline, 2);
  const StageThreads& pilot = stage_of(stages, "pilot");
  ASSERT_EQ(pilot.busy.size(), 2u);
  EXPECT_GE(sum(pilot.busy), 0.02);
  EXPECT_GE(pilot.seconds, 0.02);
  EXPECT_NEAR(pilot.partly_idle, pilot.seconds, 1e-9) << "one item can't occupy two threads";
  // With one thread, only the time before and after the item is idle.
  EXPECT_NEAR(stage_of(stage_threads(timeline, 1), "pilot").partly_idle,
              pilot.seconds - pilot.busy[0], 1e-9);
}

TEST(Timeline, CommitsAreSeparateFromWork) {
  const auto film = make<Film>("<film type=\"hdrfilm\"/>");
  film->prepare({{}});
  Timeline timeline(Timeline::Clock::now());
  RenderContext context({.threads = 2, .timeline = &timeline});
  context.scheduler.set_commit_callback([](const Film&, const Rect&) { work(1ms); });
  context.scheduler.for_each_tile(
      *film, [](Tile& tile) { const StageTimer timer(tile.counters.stage_seconds["main"]); });
  const auto stages = stage_threads(timeline, 2);
  const StageThreads& stage = stage_of(stages, "main");
  EXPECT_GE(sum(stage.committing), 1e-3);
  EXPECT_LE(sum(stage.busy) + sum(stage.committing), 2 * stage.seconds + 1e-6);
  size_t commits = 0, items = 0;
  for (const auto& events : timeline.events()) {
    for (const Timeline::Event& event : events) {
      if (timeline.parts()[event.part].stage != "main") continue;
      ++(event.is_commit ? commits : items);
    }
  }
  EXPECT_GT(commits, 100u);
  EXPECT_GE(items, commits);
}

TEST(Timeline, RecordingDoesNotChangeTheResult) {
  const auto run = [](Timeline* timeline) {
    RenderContext context({.threads = 3, .timeline = timeline});
    run_stages(context);
    return context.job.stats().counters.stage_seconds["shade"];
  };
  Timeline timeline(Timeline::Clock::now());
  EXPECT_EQ(run(&timeline), run(nullptr));
}

TEST(Timeline, IsCompleteAfterAnException) {
  Timeline timeline(Timeline::Clock::now());
  RenderContext context({.threads = 2, .timeline = &timeline});
  EXPECT_THROW(context.scheduler.for_each(
                   3, [](size_t, RenderCounters&) { throw std::runtime_error("item"); }),
               std::runtime_error);
  context.scheduler.for_each(3, [](size_t, RenderCounters&) {});
  for (const Timeline::Part& part : timeline.parts()) EXPECT_GE(part.end, part.begin);
}

}  // namespace
}  // namespace kinome::test::timeline_test

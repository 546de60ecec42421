#include "kinome/stage_threads.h"

#include <algorithm>
#include <utility>

namespace kinome {
namespace {

/// Stage of parts whose stage isn't known.
constexpr const char* kOtherStage = "other";

/// Returns the time in [begin, end] in which fewer than `threads` of the intervals overlap.
double partly_idle_seconds(double begin, double end, unsigned threads,
                           const std::vector<std::pair<double, double>>& intervals) {
  std::vector<std::pair<double, int>> changes = {{end, 0}};
  for (const auto& [first, last] : intervals) {
    changes.emplace_back(first, 1);
    changes.emplace_back(last, -1);
  }
  std::sort(changes.begin(), changes.end());
  double idle = 0, time = begin;
  int working = 0;
  for (const auto& [next, change] : changes) {
    if (working < static_cast<int>(threads)) idle += next - time;
    working += change;
    time = next;
  }
  return idle;
}

}  // namespace

std::vector<StageThreads> stage_threads(const Timeline& timeline, unsigned threads) {
  std::vector<StageThreads> stages;
  const std::vector<Timeline::Part>& parts = timeline.parts();
  std::vector<std::vector<std::pair<double, double>>> work(parts.size());
  std::vector<size_t> stage_of(parts.size());
  for (size_t p = 0; p < parts.size(); ++p) {
    const std::string name = parts[p].stage.empty() ? kOtherStage : parts[p].stage;
    const auto has_name = [&](const StageThreads& stage) { return stage.stage == name; };
    const auto found = std::find_if(stages.begin(), stages.end(), has_name);
    stage_of[p] = static_cast<size_t>(found - stages.begin());
    if (found == stages.end()) {
      stages.push_back({name, 0, 0, std::vector<double>(threads), std::vector<double>(threads)});
    }
    stages[stage_of[p]].seconds += parts[p].end - parts[p].begin;
  }
  for (size_t t = 0; t < timeline.events().size() && t < threads; ++t) {
    for (const Timeline::Event& event : timeline.events()[t]) {
      StageThreads& stage = stages[stage_of[event.part]];
      (event.is_commit ? stage.committing : stage.busy)[t] += event.end - event.begin;
      if (!event.is_commit) work[event.part].emplace_back(event.begin, event.end);
    }
  }
  for (size_t p = 0; p < parts.size(); ++p) {
    stages[stage_of[p]].partly_idle +=
        partly_idle_seconds(parts[p].begin, parts[p].end, threads, work[p]);
  }
  return stages;
}

}  // namespace kinome

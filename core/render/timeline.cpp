#include "kinome/timeline.h"

#include <algorithm>
#include <utility>

namespace kinome {
namespace {

/// Stage of parts whose stage isn't known.
constexpr const char* kOtherStage = "other";

/// Returns the stage with the largest increase; "" if none has increased.
std::string largest_increase(const std::map<std::string, double>& before,
                             const std::map<std::string, double>& after) {
  std::string stage;
  double largest = 0;
  for (const auto& [name, seconds] : after) {
    const auto found = before.find(name);
    const double increase = seconds - (found == before.end() ? 0 : found->second);
    if (increase > largest) {
      largest = increase;
      stage = name;
    }
  }
  return stage;
}

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

void Timeline::name_parts(const std::string& stage) {
  for (; named_ < parts_.size(); ++named_) {
    if (parts_[named_].stage.empty()) parts_[named_].stage = stage;
  }
}

void Timeline::end_serial(const std::string& stage) {
  const double begin = parts_.empty() ? 0 : parts_.back().end;
  parts_.push_back({stage, begin, now(), false});
  if (events_.empty()) events_.resize(1);
  events_[0].push_back({parts_.size() - 1, 0, begin, parts_.back().end, false});
}

void Timeline::begin_loop(unsigned threads, const std::map<std::string, double>& seconds) {
  const std::string stage = largest_increase(seconds_, seconds);
  end_serial(stage);
  if (!stage.empty()) name_parts(stage);
  seconds_ = seconds;
  if (events_.size() < threads) events_.resize(threads);
  parts_.push_back({"", parts_.back().end, 0, true});
}

void Timeline::end_loop(const std::string& stage, const std::map<std::string, double>& seconds) {
  parts_.back().stage = stage;
  parts_.back().end = now();
  seconds_ = seconds;
}

void Timeline::add(unsigned thread, uint64_t item, double begin, double end, bool is_commit) {
  events_[thread].push_back({parts_.size() - 1, item, begin, end, is_commit});
}

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

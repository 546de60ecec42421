#include "kinome/timeline.h"

namespace kinome {
namespace {

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

}  // namespace

void Timeline::name_parts(const std::string& stage) {
  for (; named_ < parts_.size(); ++named_) {
    if (parts_[named_].stage.empty()) parts_[named_].stage = stage;
  }
}

void Timeline::end_serial(const std::string& stage) {
  if (!stage.empty()) name_parts(stage);
  const double begin = parts_.empty() ? 0 : parts_.back().end;
  parts_.push_back({stage, begin, now(), false});
  if (events_.empty()) events_.resize(1);
  events_[0].push_back({parts_.size() - 1, 0, begin, parts_.back().end, false});
}

void Timeline::begin_loop(unsigned threads, const std::map<std::string, double>& seconds) {
  const std::string stage = largest_increase(seconds_, seconds);
  end_serial(stage);
  seconds_ = seconds;
  if (events_.size() < threads) events_.resize(threads);
  parts_.push_back({"", parts_.back().end, 0, true});
}

void Timeline::end_loop(const std::string& stage, const std::map<std::string, double>& seconds) {
  if (!stage.empty()) name_parts(stage);
  parts_.back().end = now();
  seconds_ = seconds;
}

void Timeline::add(unsigned thread, uint64_t item, double begin, double end, bool is_commit) {
  events_[thread].push_back({parts_.size() - 1, item, begin, end, is_commit});
}

}  // namespace kinome

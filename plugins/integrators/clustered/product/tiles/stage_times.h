#pragma once

#include <chrono>

#include "kinome/render_context.h"

namespace kinome {

/// Adds its lifetime to the time of a stage, but not to that of the enclosing stage, so that the
/// times of stages add up. Costs as much as StageTimer.
class StageScope {
 public:
  /// `innermost` is the innermost scope of the thread; nullptr at first.
  StageScope(StageScope*& innermost, double& seconds)
      : innermost_(innermost), outer_(innermost), seconds_(seconds), start_(Clock::now()) {
    if (outer_) outer_->add_until(start_);
    innermost_ = this;
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;
  ~StageScope() {
    const Clock::time_point end = Clock::now();
    add_until(end);
    if (outer_) outer_->start_ = end;
    innermost_ = outer_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  void add_until(Clock::time_point end) {
    seconds_ += std::chrono::duration<double>(end - start_).count();
  }
  StageScope*& innermost_;
  StageScope* const outer_;
  double& seconds_;
  Clock::time_point start_;
};

/// Measures the time of the estimator's stages. One object per thread; not thread-safe.
class StageTimes {
 public:
  enum Stage { kStrata, kCandidates, kComb, kShadow, kEyeRays, kStages };

  StageTimes() { stop_counting(); }
  StageTimes(const StageTimes&) = delete;
  StageTimes& operator=(const StageTimes&) = delete;

  /// Adds the time of the following stages to RenderCounters::stage_seconds.
  void count_to(RenderCounters& counters) {
    constexpr const char* kNames[kStages] = {"strata", "candidates", "comb", "shadow", "eye rays"};
    for (int i = 0; i < kStages; ++i) seconds_[i] = &counters.stage_seconds[kNames[i]];
  }
  /// Doesn't count the following stages, because they are part of another stage.
  void stop_counting() {
    for (double*& seconds : seconds_) seconds = &uncounted_;
  }
  /// Adds the time until the end of the scope to the stage, except that of inner scopes.
  [[nodiscard]] StageScope scope(Stage stage) { return {innermost_, *seconds_[stage]}; }

 private:
  double uncounted_ = 0;
  double* seconds_[kStages];
  StageScope* innermost_ = nullptr;
};

}  // namespace kinome

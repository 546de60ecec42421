#pragma once

#include "clustered/product/stage_scope.h"
#include "kinome/render_context.h"

namespace kinome {

/// Where the seconds of the estimator's stages are counted. One per thread; not thread-safe.
class StageTimes {
 public:
  enum Stage { kStrata, kCandidates, kComb, kShadow, kEyeRays, kStages };

  StageTimes() { count_nowhere(); }
  StageTimes(const StageTimes&) = delete;
  StageTimes& operator=(const StageTimes&) = delete;

  /// Stages that begin from now on are counted to RenderCounters::stage_seconds.
  void count_to(RenderCounters& counters) {
    constexpr const char* kNames[kStages] = {"strata", "candidates", "comb", "shadow", "eye rays"};
    for (int i = 0; i < kStages; ++i) seconds_[i] = &counters.stage_seconds[kNames[i]];
  }
  /// They are parts of something that is a stage itself.
  void count_nowhere() {
    for (double*& seconds : seconds_) seconds = &untold_;
  }
  /// Until the scope ends, time is the stage's, but for that of scopes within.
  [[nodiscard]] StageScope scope(Stage stage) { return {innermost_, *seconds_[stage]}; }

 private:
  double untold_ = 0;
  double* seconds_[kStages];
  StageScope* innermost_ = nullptr;
};

}  // namespace kinome

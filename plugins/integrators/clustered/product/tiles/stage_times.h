#pragma once

#include "clustered/product/tiles/stage_scope.h"
#include "kinome/render_context.h"

namespace kinome {

/// Measures the time of the estimator's stages. One object per thread; not thread-safe.
class StageTimes {
 public:
  enum Stage { kStrata, kCandidates, kComb, kShadow, kEyeRays, kStages };

  StageTimes() { count_nowhere(); }
  StageTimes(const StageTimes&) = delete;
  StageTimes& operator=(const StageTimes&) = delete;

  /// Adds the time of the following stages to RenderCounters::stage_seconds.
  void count_to(RenderCounters& counters) {
    constexpr const char* kNames[kStages] = {"strata", "candidates", "comb", "shadow", "eye rays"};
    for (int i = 0; i < kStages; ++i) seconds_[i] = &counters.stage_seconds[kNames[i]];
  }
  /// Doesn't count the following stages, because they are part of another stage.
  void count_nowhere() {
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

#pragma once

#include <cstdint>

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
  /// A unit begins. One of several is timed for all: to ask the clock at each stage of each would
  /// take some hundredths of all time.
  void begin_unit() { weight_of_unit_ = units_++ % kUnitsForOne == 0 ? kUnitsForOne : 0; }
  /// Until the scope ends, time is the stage's, but for that of scopes within.
  [[nodiscard]] StageScope scope(Stage stage) { return {innermost_, *seconds_[stage]}; }
  /// The same of what is done for each unit.
  [[nodiscard]] StageScope scope_of_unit(Stage stage) {
    return {innermost_, *seconds_[stage], static_cast<double>(weight_of_unit_)};
  }

 private:
  static constexpr uint32_t kUnitsForOne = 8;
  uint32_t units_ = 0, weight_of_unit_ = 0;
  double untold_ = 0;
  double* seconds_[kStages];
  StageScope* innermost_ = nullptr;
};

}  // namespace kinome

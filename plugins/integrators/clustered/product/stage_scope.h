#pragma once

#include <chrono>

namespace kinome {

/// Adds the time until its end to a stage, and none of it to the stage within which that runs: so
/// that stages add up. Costs as much as StageTimer.
class StageScope {
 public:
  /// `innermost`: of those at work on one thread; nullptr at first. The time counts `weight` times;
  /// 0: no clock is asked.
  StageScope(StageScope*& innermost, double& seconds, double weight = 1)
      : innermost_(innermost), outer_(innermost), seconds_(seconds), weight_(weight) {
    if (weight_ == 0) return;
    start_ = Clock::now();
    if (outer_) outer_->add_until(start_);
    innermost_ = this;
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;
  ~StageScope() {
    if (weight_ == 0) return;
    const Clock::time_point end = Clock::now();
    add_until(end);
    if (outer_) outer_->start_ = end;
    innermost_ = outer_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  void add_until(Clock::time_point end) {
    seconds_ += weight_ * std::chrono::duration<double>(end - start_).count();
  }
  StageScope*& innermost_;
  StageScope* const outer_;
  double& seconds_;
  const double weight_;
  Clock::time_point start_;
};

}  // namespace kinome

#pragma once

#include <chrono>

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

}  // namespace kinome

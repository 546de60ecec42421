#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

#include "check.h"

namespace kinome::test {

/// Seconds for one scene, of which most take a fraction of one.
inline constexpr double kPatience = 900;

/// A check in a process of its own, which may crash, hang, or take all memory.
class Check {
 public:
  /// Starts it. `work` makes the report; `folder` is for its files; more than `patience` seconds
  /// are a hang.
  Check(std::string folder, const std::function<CheckReport(const std::string& folder)>& work,
        double patience = kPatience);
  /// Ends it, if it hasn't ended.
  ~Check();
  Check(const Check&) = delete;
  Check& operator=(const Check&) = delete;

  /// True once it has ended, by itself or for taking too long.
  bool poll();
  const CheckReport& wait();
  const CheckReport& report() const { return report_; }
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
  double patience_;
  std::chrono::steady_clock::time_point start_;
  pid_t child_ = 0;  ///< 0 once it has ended
  CheckReport report_;
};

}  // namespace kinome::test

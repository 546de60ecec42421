#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

#include "check.h"

namespace kinome::test {

/// Maximum seconds for one scene; most scenes take a fraction of one.
inline constexpr double kPatience = 900;

/// A check in its own process, which may crash, hang, or exhaust memory.
class Check {
 public:
  /// Starts the check. `work` returns the report; `folder` is for its files. More than `patience`
  /// seconds are reported as a hang.
  Check(std::string folder, const std::function<CheckReport(const std::string& folder)>& work,
        double patience = kPatience);
  /// Ends the process if it is still running.
  ~Check();
  Check(const Check&) = delete;
  Check& operator=(const Check&) = delete;

  /// Returns true once the process has ended, by itself or by the time limit.
  bool poll();
  const CheckReport& wait();
  const CheckReport& report() const { return report_; }
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
  double patience_;
  std::chrono::steady_clock::time_point start_;
  pid_t child_ = 0;  ///< 0 once the process has ended
  CheckReport report_;
};

}  // namespace kinome::test

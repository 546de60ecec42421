#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

#include "check.h"

namespace kinome::test {

/// A check in a process of its own, which may crash, hang, or take all memory.
class Check {
 public:
  /// Starts it. `work` makes the report; `folder` is for its files.
  Check(std::string folder, const std::function<CheckReport(const std::string& folder)>& work);
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
  std::chrono::steady_clock::time_point start_;
  pid_t child_ = 0;  ///< 0 once it has ended
  CheckReport report_;
};

}  // namespace kinome::test

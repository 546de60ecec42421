#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kit/request.h"
#include "kit/statistics/statistics.h"

namespace kinome::check {

/// Result of a check.
struct Outcome {
  bool passed = true;
  std::string measured;  ///< measured values, and their bounds
  std::string cause;     ///< probable fault

  /// Makes the check fail. Only the cause of the first fault is kept.
  void fail(std::string what) {
    if (passed) cause = std::move(what);
    passed = false;
  }
  /// Makes the check fail if more than one of `one_of` of `count` results is wrong. A few may be,
  /// because rounding decides at edges. `what` is a format for `wrong` and `count`.
  void fail_if_many(int wrong, int count, int one_of, const std::string& what);
};

/// Records the current attempt, which is reported if the plugin crashes.
void note_attempt(const std::string& what);

/// Calls `run` in a separate process. If it crashes, never ends or throws, the outcome is a
/// failure.
Outcome run_in_process(const std::function<Outcome()>& run);

/// List of the checks of one plugin.
class Plan {
 public:
  explicit Plan(const Request& request) : request_(request) {}

  /// Adds a check. `tests` is the number of its statistical tests, each with the false-alarm rate
  /// `alpha`. `run` is called in a separate process, where it may crash or never end.
  void add(std::string name, int tests, std::function<Outcome(double alpha)> run);
  /// Runs all checks, and prints a line for each. Returns the number of failures.
  int run() const;
  size_t size() const { return checks_.size(); }

 private:
  struct Check {
    std::string name;
    int tests;
    std::function<Outcome(double alpha)> run;
  };
  const Request& request_;
  std::vector<Check> checks_;
};

}  // namespace kinome::check

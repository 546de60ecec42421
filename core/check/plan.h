#pragma once

#include <functional>
#include <string>
#include <vector>

#include "check/request.h"
#include "check/statistics.h"

namespace kinome::check {

/// What a check found.
struct Outcome {
  bool passed = true;
  std::string measured;  ///< and its bound
  std::string cause;     ///< what is probably wrong

  /// Notes a fault: the first one's cause is told.
  void fail(std::string what) {
    if (passed) cause = std::move(what);
    passed = false;
  }
};

/// Tells what is being tried, should the plugin crash at it.
void note_attempt(const std::string& what);

/// Runs it in a process of its own, where it may crash or never end: that, and an exception, is an
/// outcome that failed.
Outcome run_apart(const std::function<Outcome()>& run);

/// The checks of one plugin.
class Plan {
 public:
  explicit Plan(const Request& request) : request_(request) {}

  /// `tests`: how many statistical tests it makes, each at the rate of false alarms that `run` is
  /// given. It runs in a process of its own, where it may crash or never end.
  void add(std::string name, int tests, std::function<Outcome(double alpha)> run);
  /// Runs all, printing a line for each. How many failed.
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

#include "kit/plan.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome::check {
namespace {

/// Probability that any check of a correct plugin fails.
constexpr double kFalseAlarms = 1e-4;
constexpr unsigned kMaxSeconds = 240;  ///< maximum duration of a check

/// Shared memory for the results of a check's process. It remains if the process crashes.
struct Shared {
  bool is_done;
  bool passed;
  char attempt[400];
  char measured[2000];
  char cause[2000];
};
Shared* shared = nullptr;

void share_memory() {
  if (shared) return;
  void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw Error("out of memory");
  shared = static_cast<Shared*>(memory);
}

template <size_t N>
void copy(const std::string& text, char (&to)[N]) {
  const size_t length = std::min(text.size(), N - 1);
  std::memcpy(to, text.data(), length);
  to[length] = 0;
}

/// Replaces line breaks by spaces.
std::string line_of(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Outcome outcome_of(const std::function<Outcome()>& run) {
  try {
    return run();
  } catch (const std::exception& error) {
    Outcome outcome;
    outcome.fail(std::string("an exception: ") + error.what());
    return outcome;
  } catch (...) {
    Outcome outcome;
    outcome.fail("an unknown exception");
    return outcome;
  }
}

/// Returns the outcome of a process that a signal terminated.
Outcome ended_by(int signal) {
  Outcome outcome;
  const std::string at = shared->attempt[0] ? std::string(" at ") + shared->attempt : "";
  outcome.fail(signal == SIGALRM ? fmt::format("not finished after {} seconds{}", kMaxSeconds, at)
                                 : fmt::format("a crash ({}){}", strsignal(signal), at));
  return outcome;
}

}  // namespace

void Outcome::fail_if_many(int wrong, int count, int one_of, const std::string& what) {
  if (wrong * one_of > count) fail(fmt::format(fmt::runtime(what), wrong, count));
}

void note_attempt(const std::string& what) {
  if (shared) copy(what, shared->attempt);
}

Outcome run_in_process(const std::function<Outcome()>& run) {
  share_memory();
  std::memset(static_cast<void*>(shared), 0, sizeof *shared);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw Error(std::string("can't start a process: ") + std::strerror(errno));
  if (child == 0) {
    alarm(kMaxSeconds);
    const Outcome outcome = outcome_of(run);
    shared->passed = outcome.passed;
    copy(outcome.measured, shared->measured);
    copy(outcome.cause, shared->cause);
    shared->is_done = true;
    std::fflush(nullptr);
    _exit(0);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return ended_by(WTERMSIG(status));
  if (!shared->is_done) {
    Outcome outcome;
    outcome.fail(fmt::format("the program ended{}{}", shared->attempt[0] ? " at " : "",
                             shared->attempt));
    return outcome;
  }
  return {shared->passed, shared->measured, shared->cause};
}

void Plan::add(std::string name, int tests, std::function<Outcome(double)> run) {
  checks_.push_back({std::move(name), tests, std::move(run)});
}

int Plan::run() const {
  std::vector<std::string> names;
  int tests = 0;
  for (const Check& check : checks_) {
    names.push_back(check.name);
    tests += check.tests;
  }
  for (const auto* chosen : {&request_.only, &request_.except}) {
    for (const std::string& name : *chosen) {
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      std::string list;
      for (const std::string& known : names) list += (list.empty() ? "" : ", ") + known;
      throw Error(fmt::format("unknown check '{}' for this plugin (available: {})", name, list));
    }
  }
  const auto is_chosen = [&](const Check& check) {
    return !request_.except.count(check.name) &&
           (request_.only.empty() || request_.only.count(check.name));
  };
  if (std::none_of(checks_.begin(), checks_.end(), is_chosen)) {
    throw Error("no check to run: --except excludes all checks of --only");
  }
  const double alpha = kFalseAlarms / std::max(tests, 1);
  int count = 0, failed = 0;
  for (const Check& check : checks_) {
    if (!is_chosen(check)) continue;
    const Outcome outcome = run_in_process([&] { return check.run(alpha); });
    ++count;
    failed += !outcome.passed;
    const std::string text =
        outcome.passed ? outcome.measured
                       : outcome.cause + (outcome.measured.empty() ? "" : ": " + outcome.measured);
    fmt::print("  {:<5} {:<14} {}\n", outcome.passed ? "ok" : "FAULT", check.name, line_of(text));
    std::fflush(stdout);
  }
  fmt::print("{} of {} checks failed; a correct plugin fails in 1 of {:.0f} runs\n", failed, count,
             1 / kFalseAlarms);
  return failed;
}

}  // namespace kinome::check

#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// Records when each thread of a scheduler worked, for `--stats` and `--trace`. Times are seconds
/// from the timeline's start.
///
/// The rendering thread's time is divided into consecutive parts: loops of the scheduler, and
/// serial parts between them. All functions except add() must be called by the thread that created
/// the timeline.
class KINOME_EXPORT Timeline {
 public:
  using Clock = std::chrono::steady_clock;
  struct Part {
    std::string stage;  ///< "" until it is known
    double begin = 0, end = 0;
    bool is_loop = false;
  };
  /// Work of a thread in a part. Events of a thread don't overlap.
  struct Event {
    size_t part = 0;
    uint64_t item = 0;
    double begin = 0, end = 0;
    /// True if the thread adds an item's result to the film, or waits for other threads that do.
    bool is_commit = false;
  };

  explicit Timeline(Clock::time_point start) : start_(start), owner_(std::this_thread::get_id()) {}

  double now() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  bool is_owner() const { return owner_ == std::this_thread::get_id(); }

  /// Ends a serial part, which began at the end of the previous part. If `stage` isn't "", it is
  /// the stage of all previous parts without a stage, too.
  void end_serial(const std::string& stage);
  /// Ends a serial part and begins a loop on at most `threads` threads. The stage of the serial
  /// part is the one whose time in `seconds` (RenderCounters::stage_seconds) has increased most. It
  /// is the stage of all previous parts without a stage, too.
  void begin_loop(unsigned threads, const std::map<std::string, double>& seconds);
  /// Ends the loop. If `stage` isn't "", it is the stage of the loop and of all previous parts
  /// without a stage, which prepared it. `seconds` is that of begin_loop(), including the loop.
  void end_loop(const std::string& stage, const std::map<std::string, double>& seconds);
  /// Adds an event of a thread in the current loop. Different threads may call it at once.
  void add(unsigned thread, uint64_t item, double begin, double end, bool is_commit);

  const std::vector<Part>& parts() const { return parts_; }
  const std::vector<std::vector<Event>>& events() const { return events_; }  ///< by thread

 private:
  void name_parts(const std::string& stage);

  const Clock::time_point start_;
  const std::thread::id owner_;
  std::vector<Part> parts_;
  std::vector<std::vector<Event>> events_;
  size_t named_ = 0;                       ///< number of parts before the first one without a stage
  std::map<std::string, double> seconds_;  ///< at the end of the last loop
};

}  // namespace kinome

#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "kinome/export.h"
#include "kinome/math.h"
#include "kinome/render_options.h"
#include "kinome/stats.h"

namespace kinome {

class WorkSource;

/// State of a render: its seed, progress, cancellation, decisions and statistics.
///
/// A render may be distributed over a group of processes (ProcessGroup). Functions marked
/// *collective* must then be called by all processes of the group, in the same order.
class KINOME_EXPORT RenderJob {
 public:
  explicit RenderJob(RenderOptions options);

  const RenderBudget& budget() const { return options_.budget; }
  ProcessGroup* group() const { return options_.group; }  ///< nullptr: a single process
  /// Seconds since RenderOptions::start, by RenderOptions::clock.
  double seconds() const { return options_.clock(); }
  RenderStats& stats() { return stats_; }
  /// Records for `--stats` that `what` was skipped, and `why`. Thread-safe.
  void skip(std::string what, std::string why);

  /// Begins another pass over the image. seed() changes with `index` (RenderOptions::seed for 0);
  /// progress from 0 to 1 within the pass is reported as `begin` to `end`.
  void begin_pass(uint64_t index, double begin, double end);
  /// Seed of the current pass, mixed into every SampleKey.
  uint64_t seed() const;
  /// Sets the range of progress that the scheduler's next loop covers within the current pass.
  /// Default: 0 to 1, for integrators with a single loop.
  void set_progress_range(double begin, double end);

  /// Sets the time of the clock [s] from which cancelled() is true; infinity: never.
  void set_deadline(double seconds);
  /// True if the user ended the render (RenderOptions::cancel). In a group, an interrupted process
  /// interrupts all others at the end of the scheduler's current loop; between loops, all processes
  /// agree.
  bool interrupted() const;
  /// True if interrupted() or past the deadline; the image then consists of the samples so far. In
  /// a group, processes agree as for interrupted().
  bool cancelled() const;
  /// Cancels the current item if this process belongs to a group and was interrupted: throws an
  /// exception that the scheduler catches. Long items call it between their steps, because
  /// launchers kill processes that don't end within a second. Does nothing without a group.
  void check_interrupt() const;

  /// Sets an object that records finished items and skips those it has, such as a Checkpoint;
  /// nullptr: none. Call before rendering.
  void set_work_source(WorkSource* source) { source_ = source; }
  WorkSource* work_source() const { return source_; }
  /// True if some of `pixels` of a film layer need samples (WorkSource::is_wanted()).
  bool is_wanted(const Rect& pixels, int layer = 0) const;
  /// Returns decide(). Integrators must use it for decisions that depend on the film's contents. A
  /// resumed render gets the decisions of the original render, because its film has later contents.
  /// In a group, returns the root's decision. Collective.
  double decide(const std::function<double()>& decide) const;

 private:
  friend class Scheduler;
  /// Progress of the whole render at a progress within the pass, both 0 to 1.
  double overall_progress(double of_pass) const {
    return pass_begin_ + (pass_end_ - pass_begin_) * of_pass;
  }
  bool is_interrupted_here() const { return options_.cancel && options_.cancel->load(); }
  bool is_late_here() const { return deadline_ < kInfinity && seconds() > deadline_; }

  RenderOptions options_;
  RenderStats stats_;
  WorkSource* source_ = nullptr;
  uint64_t pass_ = 0;
  double pass_begin_ = 0, pass_end_ = 1;
  double progress_begin_ = 0, progress_end_ = 1;
  double deadline_ = kInfinity;
  /// State that the group agreed on at the end of the last loop. Within a loop, each process uses
  /// its own.
  std::atomic<bool> group_interrupted_{false}, group_late_{false}, group_at_work_{false};
};

}  // namespace kinome

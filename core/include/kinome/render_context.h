#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kinome/film.h"
#include "kinome/scene.h"
#include "kinome/stats.h"

namespace kinome {

class Commits;
class ProcessGroup;
class SharedItems;
class ThreadPool;
class WorkSource;

/// Side of a tile in pixels (Åkerlund 2008, 4.4.1).
inline constexpr int kTileSize = 32;

/// Tile that one thread is rendering.
struct Tile {
  Rect pixels;
  FilmTile& film;
  RenderCounters& counters;
};

/// Called now and then during a render, by one thread at a time, with the fraction of tiles done.
using ProgressCallback = std::function<void(double fraction)>;

/// Called after samples were added to the film, by one thread at a time. The caller holds the lock
/// of the film's commits, so the callback must be fast and must not call the context. `pixels`
/// contains the new samples, not their filter's border; it is the whole crop window if there are
/// splats.
using CommitCallback = std::function<void(const Film& film, const Rect& pixels)>;

/// Stopping criteria of a progressive render, in place of the scene's sample count. They can be
/// combined; with a time and an error, the first one reached ends the render.
struct RenderBudget {
  /// Time of Options::clock [s] at which the caller must be done with the image; 0: no limit. The
  /// first pass, which has the fewest samples, is always completed.
  double seconds = 0;
  /// Target for the estimated relMSE: the mean of variance / (colour² + 0.01 mean²) over pixels and
  /// channels; 0: none. The render stops at kMaxSamples samples per pixel, or at the scene's sample
  /// count if that is larger.
  double rel_mse = 0;
  static constexpr double kMaxSamples = 16384;
  /// Number of film lanes (at least 2) for Film::noise(); 0: no variance estimates.
  uint32_t lanes = 0;
  /// Estimates the seconds that the caller needs after the render for an image like `picture`, for
  /// example to write it. They are part of `seconds`.
  std::function<double(const Image& picture)> seconds_after = nullptr;
  bool any() const { return seconds > 0 || rel_mse > 0 || lanes > 0; }
};

/// Services that an integrator needs besides the scene: parallel loops, seeds, progress,
/// cancellation and statistics. Integrators create no threads themselves.
///
/// A render may be distributed over a group of processes (ProcessGroup). Functions marked
/// *collective* must then be called by all processes of the group, in the same order.
class KINOME_EXPORT RenderContext {
 public:
  struct Options {
    unsigned threads = 0;  ///< 0: one per core
    uint64_t seed = 0;
    const std::atomic<bool>* cancel = nullptr;  ///< set to true by the caller to end the render
    ProgressCallback progress = nullptr;
    /// Shuffles the order in which tiles are rendered; results don't depend on it.
    uint64_t tile_order_seed = 0;
    /// Start of the program, for RenderStats::first_tile_seconds and for `clock`.
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    RenderBudget budget = {};
    /// Returns the seconds since `start`; nullptr: the system's steady clock. Thread-safe.
    std::function<double()> clock = nullptr;
    /// Group of processes that render the same image with the same options, except for threads,
    /// progress and clock. nullptr: a single process. Must outlive the context.
    ProcessGroup* group = nullptr;
  };
  /// Starts the threads, which sleep until they are used. Create the context before loading the
  /// scene, not right before rendering: the system may take milliseconds to distribute new threads
  /// over the cores.
  explicit RenderContext(Options options);
  ~RenderContext();

  /// Calls `fn` for each 32x32 tile of Film::sampled() on all threads, with denormals flushed, and
  /// commits the tiles to the film in their order. Starts no further tiles once cancelled. Rethrows
  /// the first exception. Collective.
  void for_each_tile(Film& film, const std::function<void(Tile&)>& fn, int layer = 0);
  /// Calls fn(i, counters) for i < count on all threads, with denormals flushed. Reports progress,
  /// rethrows the first exception, and starts no further items once cancelled. Collective.
  ///
  /// In a group, each process runs some of the items. Samples that `fn` passes to commit() reach
  /// the root's film. Other results stay in the process that computed them unless `shared`
  /// transfers them.
  void for_each(size_t count, const std::function<void(size_t, RenderCounters&)>& fn,
                SharedItems* shared = nullptr);
  /// Adds the results of one item of the current for_each() to the film. Must be called once per
  /// item with all of its tiles, because checkpoints count whole items. Items are added in order;
  /// an item waits in memory until all previous items are committed. Thread-safe.
  void commit(Film& film, size_t item, std::vector<FilmTile> tiles);
  /// True if the item of the current for_each() needs no work: it is in the film already (resumed
  /// render), or not wanted (set_gaps()).
  bool is_committed(size_t item) const;
  /// Restricts rendering to tiles that cover a pixel of `gaps`, given for each film layer (see
  /// Film::gaps()) over the window `crop`. for_each_tile() skips all others.
  void set_gaps(const Rect& crop, std::vector<std::vector<bool>> gaps);
  /// True if some of `pixels` must be rendered: always, unless set_gaps() was called.
  bool is_wanted(const Rect& pixels, int layer = 0) const;
  /// Returns decide(). Integrators must use it for decisions that depend on the film's contents. A
  /// resumed render gets the decisions of the original render, because its film has later contents.
  /// In a group, returns the root's decision. Collective.
  double decide(const std::function<double()>& decide);
  /// Returns the root's `value`, so that all processes use the same one, for example of the time.
  /// Collective.
  double agree(double value);
  /// Sums each value over all processes of the group (all-reduce). Collective.
  void add_up(std::span<uint64_t> numbers);
  /// True on the process that owns the film. Always true without a group.
  bool is_root() const;
  ProcessGroup* group() const { return options_.group; }
  /// Sets the film of the root to which other processes' commits are added. Call before rendering.
  void set_film(Film& film) { film_ = &film; }
  /// Sets an object that records finished items and skips those it has, such as a Checkpoint;
  /// nullptr: none. Call before rendering.
  void set_work_source(WorkSource* source) { work_source_ = source; }
  WorkSource* work_source() const { return work_source_; }
  /// Sets a callback that observes the film, or nullptr. Results don't depend on it. Call before
  /// rendering.
  void set_commit_callback(CommitCallback callback) { on_commit_ = std::move(callback); }
  const CommitCallback& commit_callback() const { return on_commit_; }
  /// Sets the range of progress that the next for_each() or for_each_tile() covers within the
  /// current pass. Default: 0 to 1, for integrators with a single loop.
  void set_progress_range(double begin, double end);
  /// Begins another pass over the image. seed() changes with `index` (Options::seed for 0);
  /// progress from 0 to 1 within the pass is reported as `begin` to `end`.
  void begin_pass(uint64_t index, double begin, double end);
  /// Sets the time of the clock [s] from which cancelled() is true; infinity: never.
  void set_deadline(double seconds);
  /// Calls fn(i) for i < count on all threads of this process, for setup work. Results must not
  /// depend on the order.
  void parallel_for(size_t count, const std::function<void(size_t)>& fn) const;

  /// Seed of the current pass, mixed into every SampleKey.
  uint64_t seed() const { return pass_ == 0 ? options_.seed : hash_words(options_.seed, pass_); }
  unsigned threads() const { return options_.threads; }
  /// Number of threads of all processes of the group.
  unsigned all_threads() const { return all_threads_; }
  const RenderBudget& budget() const { return options_.budget; }
  /// Seconds since Options::start, by Options::clock.
  double seconds() const { return options_.clock(); }
  /// True if the user ended the render (Options::cancel). In a group, an interrupted process
  /// interrupts all others at the end of the current for_each(); between loops, all processes
  /// agree.
  bool interrupted() const;
  /// True if interrupted() or past the deadline; the image then consists of the samples so far. In
  /// a group, processes agree as for interrupted().
  bool cancelled() const;
  /// Cancels the current item if an interrupted process of a group runs it, by an exception that
  /// for_each() catches. Long items call it between their steps, because launchers kill processes
  /// that don't end within a second. Without a group, items are completed.
  void give_up_if_asked() const;
  RenderStats& stats() { return stats_; }
  /// Records for `--stats` that `what` was skipped, and `why`.
  void skip(std::string what, std::string why);

 private:
  Options options_;
  uint64_t pass_ = 0;
  double pass_begin_ = 0;
  double pass_end_ = 1;
  double deadline_ = kInfinity;
  double progress_begin_ = 0;
  double progress_end_ = 1;
  RenderStats stats_;
  std::unique_ptr<ThreadPool> pool_;
  unsigned all_threads_ = 0;
  WorkSource* work_source_ = nullptr;
  Rect gaps_crop_;
  std::vector<std::vector<bool>> gaps_;  ///< per layer; empty: render all pixels
  std::vector<bool> left_out_;           ///< items of the current for_each() to skip
  friend class Commits;
  /// Adds an item to the film when it is its turn.
  void add(Film& film, size_t item, const std::vector<FilmTile>& tiles);
  bool is_interrupted_here() const { return options_.cancel && options_.cancel->load(); }
  bool is_late_here() const { return deadline_ < kInfinity && seconds() > deadline_; }
  std::vector<size_t> items_to_do(size_t count);
  void end_pass();

  CommitCallback on_commit_;
  std::unique_ptr<Commits> commits_;  ///< of the current for_each()
  Film* film_ = nullptr;
  /// State that the group agreed on at the end of the last for_each(). Within a for_each(), each
  /// process uses its own.
  std::atomic<bool> group_interrupted_{false}, group_late_{false}, group_at_work_{false};
};

/// Warns if the scene has no emitter, for integrators that show only emitted light.
KINOME_EXPORT void warn_without_emitters(const Scene& scene);

}  // namespace kinome

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

class Checkpoint;
class Commits;
class ProcessGroup;
class SharedItems;
class ThreadPool;

/// Side of a tile in pixels (Åkerlund 2008, 4.4.1).
inline constexpr int kTileSize = 32;

/// One tile, being rendered by one thread.
struct Tile {
  Rect pixels;
  FilmTile& film;
  RenderCounters& counters;
};

/// Called from time to time by one thread at a time, with the share of tiles done.
using ProgressCallback = std::function<void(double fraction)>;

/// Called whenever samples have come to the film, by one thread at a time, which holds a lock that
/// keeps others from adding to it: to be quick, and not to call the context. `pixels` is where
/// they count, but for their filter's border; all of the crop window where there are splats.
using CommitCallback = std::function<void(const Film& film, const Rect& pixels)>;

/// When a picture is good enough, where that isn't the scene's number of samples. Any of the three
/// may be asked for together; where time and error both are, whichever comes first ends the render.
struct RenderBudget {
  /// Of Options::clock, at which the caller is to be done with the picture; 0: no limit. The first
  /// pass, of the fewest samples, is finished in any case.
  double seconds = 0;
  /// Estimated relMSE, mean of variance / (colour² + 0.01 mean²) over pixels and channels, at which
  /// to stop; 0: not asked for. Stops at kMostSamples in any case.
  double rel_mse = 0;
  static constexpr double kMostSamples = 16384;
  /// Lanes of the film, 2 or more, for Film::noise; 0: it isn't asked for.
  uint32_t lanes = 0;
  /// How long the caller will take for a picture like this, in seconds: part of `seconds`.
  std::function<double(const Image& picture)> seconds_after = nullptr;
  bool any() const { return seconds > 0 || rel_mse > 0 || lanes > 0; }
};

/// What an integrator needs besides the scene: threads (hidden), seed, progress, cancel, stats.
class KINOME_EXPORT RenderContext {
 public:
  struct Options {
    unsigned threads = 0;  ///< 0: one per core
    uint64_t seed = 0;
    const std::atomic<bool>* cancel = nullptr;  ///< set by whoever wants the render to end
    ProgressCallback progress = nullptr;
    /// Permutes the order in which tiles are handed out; results do not depend on it.
    uint64_t tile_order_seed = 0;
    /// Start of the program, for RenderStats::first_tile_seconds and for `clock`.
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    RenderBudget budget = {};
    /// Seconds since `start`. Called by many threads.
    std::function<double()> clock = nullptr;
    /// Which render the same picture, with the same options but threads, progress and clock;
    /// nullptr: this process is alone. Must outlive the context.
    ProcessGroup* group = nullptr;
  };
  /// Starts the threads, which sleep until they are needed: make it ahead of loading the scene, not
  /// right before the render (see ThreadPool).
  explicit RenderContext(Options options);
  ~RenderContext();

  /// Calls `fn` for each 32x32 tile of the film's crop window (grown by the filter's radius where
  /// the film samples its border), on all threads (denormals flushed), and commits each to the film
  /// in the tiles' own order. Rethrows the first exception. Stops handing out tiles when cancelled.
  void for_each_tile(Film& film, const std::function<void(Tile&)>& fn, int layer = 0);
  /// Calls fn(i, counters) for i < count on all threads (denormals flushed), as for_each_tile does
  /// with tiles: progress is told, exceptions are rethrown, a cancelled context hands out no more.
  ///
  /// Of a group of processes each does some of the items, and all must call this. What fn leaves in
  /// the film, by commit, comes to the group's root; what it leaves anywhere else must be handed on
  /// by `shared` (see there), or stays where it was made.
  void for_each(size_t count, const std::function<void(size_t, RenderCounters&)>& fn,
                SharedItems* shared = nullptr);
  /// Adds to the film what an item of the for_each at work has made, once for each item: the whole
  /// of it at once, which is what checkpoints count by. Items are added in their own order, and
  /// wait for those before them: behind one that is slow, in memory. Thread-safe.
  void commit(Film& film, size_t item, std::vector<FilmTile> tiles);
  /// An item of the for_each at work is in the film already.
  bool is_committed(size_t item) const;
  /// Renders no more than what covers one of these pixels, for each layer of the film
  /// (Film::gaps): for_each_tile leaves the other tiles out.
  void set_gaps(const Rect& crop, std::vector<std::vector<bool>> gaps);
  /// Whether pixels are to be rendered: all are, unless there are gaps to be filled.
  bool is_wanted(const Rect& pixels, int layer = 0) const;
  /// What `decide` says. To be asked for what depends on the film's contents: in a resumed render
  /// these are of a later time, and the answer is that of the render before. In a group of
  /// processes, where all must ask, it is that of the root, which has the film.
  double decide(const std::function<double()>& decide);
  /// The root's `value`, for what processes know each by themselves, such as the time. All of a
  /// group must ask.
  double agree(double value);
  /// Makes of each number the sum of what all processes of a group have. All must ask.
  void add_up(std::span<uint64_t> numbers);
  /// Has the film, and the last word: one process of a group, or this one, alone.
  bool is_root() const;
  ProcessGroup* group() const { return options_.group; }
  /// Where the root adds what other processes commit: before a render.
  void set_film(Film& film) { film_ = &film; }
  /// Keeps what is finished, and leaves out what was: before a render. nullptr: nothing is kept.
  void set_checkpoint(Checkpoint* checkpoint) { checkpoint_ = checkpoint; }
  Checkpoint* checkpoint() const { return checkpoint_; }
  /// Sees the film fill, before a render; nullptr: no one does. Results do not depend on it.
  void set_commit_callback(CommitCallback callback) { on_commit_ = std::move(callback); }
  const CommitCallback& commit_callback() const { return on_commit_; }
  /// The part of the whole work that the next for_each or for_each_tile is: what progress counts
  /// as. 0 to 1 unless said, which is right for a single pass.
  void set_progress_range(double begin, double end);
  /// Another pass over the picture begins: seed() changes with `index` (0: Options::seed), and what
  /// is progress from 0 to 1 in the pass is told as `begin` to `end`.
  void begin_pass(uint64_t index, double begin, double end);
  /// From this time of the clock on cancelled() is true; infinite: never.
  void set_deadline(double seconds);
  /// Calls fn(i) for i < count on all threads; for set-up work. Results must not depend on order.
  void parallel_for(size_t count, const std::function<void(size_t)>& fn) const;

  /// Mixed into every SampleKey.
  uint64_t seed() const { return pass_ == 0 ? options_.seed : hash_words(options_.seed, pass_); }
  unsigned threads() const { return options_.threads; }
  /// Of all processes of the group.
  unsigned all_threads() const { return all_threads_; }
  const RenderBudget& budget() const { return options_.budget; }
  /// Of Options::clock.
  double seconds() const { return options_.clock(); }
  /// By whoever wants the render to end. In a group of processes, whoever is interrupted
  /// interrupts all, at the end of the for_each at work: outside of it, all say the same.
  bool interrupted() const;
  /// Interrupted, or out of time: what there is is the picture. In a group as interrupted().
  bool cancelled() const;
  /// To be called between the parts of an item that takes long. In a group of processes that is
  /// interrupted, throws what for_each catches: the item is given up, as launchers kill processes
  /// that don't end within a second. Alone, a process finishes what it has begun.
  void give_up_if_asked() const;
  RenderStats& stats() { return stats_; }
  /// Notes for `--stats` that work was skipped, and why.
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
  Checkpoint* checkpoint_ = nullptr;
  Rect gaps_crop_;
  std::vector<std::vector<bool>> gaps_;  ///< of each layer; none: all is to be rendered
  std::vector<bool> left_out_;           ///< items of the for_each at work
  friend class Commits;
  /// Adds an item to the film, whose turn it is.
  void add(Film& film, size_t item, const std::vector<FilmTile>& tiles);
  bool is_interrupted_here() const { return options_.cancel && options_.cancel->load(); }
  bool is_late_here() const { return deadline_ < kInfinity && seconds() > deadline_; }
  std::vector<size_t> items_to_do(size_t count);
  void end_pass();

  CommitCallback on_commit_;
  std::unique_ptr<Commits> commits_;  ///< of the for_each at work
  Film* film_ = nullptr;
  /// What all of a group have agreed on at the end of the last for_each; while one is at work, each
  /// process looks by itself.
  std::atomic<bool> group_interrupted_{false}, group_late_{false}, group_at_work_{false};
};

/// Warns if the scene has no emitter at all: for integrators that show nothing but light.
KINOME_EXPORT void warn_without_emitters(const Scene& scene);

/// Prepares the film, renders with the scene's integrator until the context's budget is spent (or
/// the sampler's samples, where there is none), and fills the context's stats. With
/// RenderBudget::lanes the image has the channels of Film::noise, too.
KINOME_EXPORT Image render(const Scene& scene, const Sensor& sensor, RenderContext& context);

}  // namespace kinome

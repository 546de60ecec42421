#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "kinome/film.h"
#include "kinome/stats.h"

namespace kinome {

class RenderJob;
class SharedItems;

/// Side of a tile in pixels (Åkerlund 2008, 4.4.1). Small images have smaller tiles, because they
/// would otherwise have too few for many threads.
inline constexpr int kTileSize = 32, kSmallTileSize = 16;
/// Returns the side of the tiles of an image with these pixels.
KINOME_EXPORT int tile_size(const Rect& pixels);

/// Tile that one thread is rendering.
struct Tile {
  Rect pixels;
  FilmTile& film;
  RenderCounters& counters;
};

/// Called after samples were added to the film, by one thread at a time. The caller holds the lock
/// of the film's commits, so the callback must be fast and must not call the scheduler. `pixels`
/// contains the new samples, not their filter's border; it is the whole crop window if there are
/// splats.
using CommitCallback = std::function<void(const Film& film, const Rect& pixels)>;

/// Runs loops of a render on threads. Integrators create no threads themselves. Results are added
/// to the film in the order of their items, so the image has the same bits at any number of
/// threads.
///
/// Functions marked *collective* must be called by all processes of a group (see RenderJob).
class KINOME_EXPORT Scheduler {
 public:
  /// Starts the threads, which sleep until they are used. The job must outlive the scheduler.
  /// Collective.
  explicit Scheduler(RenderJob& job);
  ~Scheduler();

  /// Calls `fn` for each tile of Film::sampled() on all threads, with denormals flushed, and
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
  /// Calls fn(i) for i < count on all threads of this process, for setup work. Results must not
  /// depend on the order.
  void parallel_for(size_t count, const std::function<void(size_t)>& fn) const;

  unsigned threads() const;      ///< number of threads of this process
  unsigned all_threads() const;  ///< number of threads of all processes of the group

  /// Sets the film of the root to which other processes' commits are added. Call before rendering.
  void set_film(Film& film);
  /// Sets a callback that observes the film, or nullptr. Results don't depend on it. Call before
  /// rendering.
  void set_commit_callback(CommitCallback callback);
  const CommitCallback& commit_callback() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kinome

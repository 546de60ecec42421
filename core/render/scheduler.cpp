#include "kinome/scheduler.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>

#include "base/denormals.h"
#include "kinome/process_group.h"
#include "kinome/render_job.h"
#include "kinome/sampler.h"
#include "kinome/shared_items.h"
#include "kinome/work_source.h"
#include "render/commits.h"
#include "render/group_pass.h"
#include "render/item_cancelled.h"
#include "render/item_timer.h"
#include "render/progress.h"
#include "render/thread_pool.h"

namespace kinome {
namespace {

std::vector<Rect> tiles_of(const Rect& region) {
  std::vector<Rect> tiles;
  const int side = tile_size(region);
  for (int y = region.y0; y < region.y1; y += side) {
    for (int x = region.x0; x < region.x1; x += side) {
      tiles.push_back({x, y, std::min(x + side, region.x1), std::min(y + side, region.y1)});
    }
  }
  return tiles;
}

/// Returns the order in which `count` tiles are rendered: by index for seed 0, else shuffled.
std::vector<size_t> tile_order(size_t count, uint64_t seed) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  if (seed != 0) {
    for (size_t i = count; i > 1; --i) {
      std::swap(order[i - 1], order[hash_words(seed, i) % i]);
    }
  }
  return order;
}

/// Returns the stage that takes most of a loop's time, or "tiles" if there are several.
std::string stage_of_loop(const RenderCounters& counters, std::span<const Stage> stages) {
  constexpr double kMinShare = 0.8;
  double sum = 0;
  std::pair<double, std::string> largest{0, ""};
  for (const auto& [stage, seconds] : counters.stage_seconds) {
    const bool is_nested =
        std::any_of(stages.begin(), stages.end(), [&, &name = stage](const Stage& s) {
          return s.name == name && counters.stage_seconds.contains(s.within);
        });
    if (is_nested) continue;
    sum += seconds;
    largest = std::max(largest, {seconds, stage});
  }
  return sum > 0 && largest.first >= kMinShare * sum ? largest.second : "tiles";
}

unsigned threads_of(unsigned requested) {
  return requested > 0 ? requested : std::max(1u, std::thread::hardware_concurrency());
}

unsigned sum_of_threads(ProcessGroup* group, unsigned threads) {
  uint64_t sum = threads;
  sum_over_processes(group, {&sum, 1});
  return static_cast<unsigned>(sum);
}

}  // namespace

int tile_size(const Rect& pixels) {
  constexpr int kSmallArea = 1 << 20;  // has 1,024 large tiles
  return pixels.area() < kSmallArea ? kSmallTileSize : kTileSize;
}

struct Scheduler::State {
  using Item = std::function<void(size_t, RenderCounters&)>;

  explicit State(RenderJob& of)
      : job(of),
        group(of.group()),
        threads(threads_of(of.options_.threads)),
        all_threads(sum_of_threads(group, threads)),
        pool(threads) {}

  /// Runs a loop. `left_out` marks items that need no work; it may be empty.
  void run(size_t count, const Item& fn, SharedItems* shared, std::vector<bool> left_out);
  /// Returns the timeline for a loop that this thread begins; nullptr if it isn't recorded, because
  /// it runs within an item or on another thread than the render.
  Timeline* recorded() const {
    Timeline* const timeline = job.options_.timeline;
    return timeline && timeline->is_owner() && !ItemTimer::current() ? timeline : nullptr;
  }

  RenderJob& job;
  ProcessGroup* const group;
  const unsigned threads, all_threads;
  mutable ThreadPool pool;
  Film* film = nullptr;
  CommitCallback on_commit;
  std::unique_ptr<Commits> commits;  ///< of the current loop

 private:
  struct Loop {
    const Item& fn;
    size_t count, to_do;        ///< all items; those that need work, of all processes
    std::vector<size_t> order;  ///< items that this process can take
    bool stays;                 ///< no other process can take them
    Timeline* timeline;
    LoopProgress progress;
    std::vector<RenderCounters> counters;  ///< by thread
    std::optional<GroupPass> pass = {};
    FirstException exception = {};
    std::atomic<size_t> next{0};
  };
  std::vector<size_t> items_to_do(size_t count);
  /// Processes items on one thread until none is left.
  void process_items(Loop& loop, unsigned thread);
  void end_loop(Loop& loop);
};

Scheduler::Scheduler(RenderJob& job) : state_(std::make_unique<State>(job)) {
  job.stats().threads = state_->threads;
  if (job.group()) job.stats().processes = static_cast<unsigned>(job.group()->size());
}

Scheduler::~Scheduler() = default;

void Scheduler::for_each_tile(Film& film, const std::function<void(Tile&)>& fn, int layer) {
  const std::vector<Rect> tiles = tiles_of(film.sampled());
  std::vector<bool> left_out;
  for (const Rect& tile : tiles) {
    left_out.push_back(!state_->job.is_wanted(tile, film.first_layer() + layer));
  }
  const auto render = [&](size_t index, RenderCounters& counters) {
    std::vector<FilmTile> film_tiles;
    film_tiles.push_back(film.make_tile(tiles[index], layer));
    Tile tile{tiles[index], film_tiles[0], counters};
    fn(tile);
    commit(film, index, std::move(film_tiles));
  };
  state_->run(tiles.size(), render, nullptr, std::move(left_out));
}

void Scheduler::for_each(size_t count, const std::function<void(size_t, RenderCounters&)>& fn,
                         SharedItems* shared) {
  state_->run(count, fn, shared, {});
}

void Scheduler::commit(Film& film, size_t item, std::vector<FilmTile> tiles) {
  if (ItemTimer* const timer = ItemTimer::current()) timer->begin_commit();
  Commits* const commits = state_->commits.get();
  if (!is_root(state_->group)) {
    if (!commits) {
      throw std::logic_error("in a group of processes, only items of a for_each are committed");
    }
    state_->group->send(Commits::pack(item, std::move(tiles)));
  } else if (commits) {
    commits->finish(film, item, std::move(tiles));
  } else {
    Commits(state_->job.work_source(), state_->on_commit).add(film, item, tiles);
  }
}

/// Returns the items that need work, in the order in which they are processed. The result is the
/// same for all processes of a group. Collective.
std::vector<size_t> Scheduler::State::items_to_do(size_t count) {
  std::vector<size_t> order = tile_order(count, job.options_.tile_order_seed);
  if (group) {
    // Only the root knows which items are in the film.
    std::string done;
    for (size_t item = 0; is_root(group) && job.work_source() && item < count; ++item) {
      done.push_back(commits->is_done(item) ? 1 : 0);
    }
    done = group->broadcast(done, "decisions");
    if (!is_root(group)) commits->leave_out({done.begin(), done.end()});
  }
  std::erase_if(order, [&](size_t item) { return commits->is_done(item); });
  return order;
}

void Scheduler::State::run(size_t count, const Item& fn, SharedItems* shared,
                           std::vector<bool> left_out) {
  if (job.work_source()) job.work_source()->begin_pass(count);
  commits = std::make_unique<Commits>(job.work_source(), on_commit);
  commits->leave_out(std::move(left_out));
  std::vector<size_t> order = items_to_do(count);
  const size_t to_do = order.size();
  const bool stays = group && shared && !shared->assigned_ranks().empty();
  if (stays) {
    std::erase_if(order,
                  [&](size_t item) { return shared->assigned_ranks()[item] != group->rank(); });
  }
  const auto used_threads = static_cast<unsigned>(std::clamp<size_t>(order.size(), 1, threads));
  Loop loop{fn,
            count,
            to_do,
            std::move(order),
            stays,
            recorded(),
            LoopProgress(job.options_.progress, count, count - to_do,
                         job.overall_progress(job.progress_begin_),
                         job.overall_progress(job.progress_end_)),
            std::vector<RenderCounters>(used_threads)};
  RenderStats& stats = job.stats();
  if (stats.first_tile_seconds == 0) stats.first_tile_seconds = job.seconds();
  if (loop.timeline) loop.timeline->begin_loop(used_threads, stats.counters.stage_seconds);
  if (group) {
    loop.pass.emplace(*group, shared, count);
    group->begin_pass([&](int, std::string_view bytes) {
      const DenormalGuard guard;
      commits->receive(*film, bytes);
    });
    job.group_at_work_ = true;
  }
  pool.run(used_threads, [&](unsigned thread) { process_items(loop, thread); });
  end_loop(loop);
}

void Scheduler::State::process_items(Loop& loop, unsigned thread) {
  while (!loop.exception.any() && !job.cancelled()) {
    const size_t turn =
        group && !loop.stays ? group->next() : loop.next.fetch_add(1, std::memory_order_relaxed);
    if (turn >= loop.order.size()) return;
    const size_t index = loop.order[turn];
    try {
      {
        const ItemTimer timer(loop.timeline, thread, index);
        loop.fn(index, loop.counters[thread]);
      }
      if (loop.pass) loop.pass->add_finished(index);
      if (group) {
        // The progress of all processes is about the number of items distributed so far.
        const size_t done_before = loop.count - loop.to_do;
        loop.progress.report(done_before + (turn + 1) * loop.to_do / loop.order.size());
      } else {
        loop.progress.add_done();
      }
    } catch (const ItemCancelled&) {
      break;
    } catch (...) {
      loop.exception.capture(index);
    }
  }
  if (group && (loop.exception.any() || job.cancelled())) group->stop();
}

void Scheduler::State::end_loop(Loop& loop) {
  WorkSource* const source = job.work_source();
  RenderStats& stats = job.stats();
  RenderCounters sum;
  for (const RenderCounters& c : loop.counters) sum.add(c);
  const std::string stage = loop.timeline ? stage_of_loop(sum, stats.stages) : "";
  const auto finish = [&] {
    commits->commit_rest();
    commits.reset();
    if (loop.timeline) loop.timeline->end_loop(stage, stats.counters.stage_seconds);
  };
  // Save the checkpoint before waiting for the other processes: they may have been killed, and this
  // one may be soon.
  if (group && job.is_interrupted_here()) commits->save();
  try {
    if (loop.pass) {
      const GroupPass::Outcome outcome = loop.pass->end(
          job.is_interrupted_here(), job.is_late_here(), std::move(sum), loop.exception);
      job.group_at_work_ = false;
      job.group_interrupted_ = job.group_interrupted_ || outcome.interrupted;
      job.group_late_ = outcome.late;
      sum = outcome.counters;
      if (!job.cancelled()) loop.progress.report(loop.count);
    }
    stats.counters.add(sum);
    loop.exception.rethrow();
  } catch (...) {
    job.group_at_work_ = false;
    if (source && commits->film()) source->abandon();
    finish();
    throw;
  }
  // Close the checkpoint before the remaining items are added: a resumed render must add items in
  // their order, and commit_rest() doesn't.
  if (source && commits->film() && job.cancelled()) source->close(*commits->film());
  finish();
}

void Scheduler::parallel_for(size_t count, const std::function<void(size_t)>& fn) const {
  if (count == 0) return;
  const auto threads = static_cast<unsigned>(std::min<size_t>(count, state_->threads));
  FirstException exception;
  std::atomic<size_t> next{0};
  // Blocks reduce the cost of the counter for short bodies, and are small enough to balance long
  // ones.
  const size_t block = std::max<size_t>(1, count / (size_t{64} * threads));
  Timeline* const timeline = state_->recorded();
  const auto& stage_seconds = state_->job.stats().counters.stage_seconds;
  if (timeline) timeline->begin_loop(threads, stage_seconds);
  state_->pool.run(threads, [&](unsigned thread) {
    while (!exception.any()) {
      const size_t first = next.fetch_add(block, std::memory_order_relaxed);
      if (first >= count) return;
      const ItemTimer timer(timeline, thread, first);
      for (size_t i = first; i < std::min(first + block, count); ++i) {
        try {
          fn(i);
        } catch (...) {
          exception.capture(i);
          return;
        }
      }
    }
  });
  if (timeline) timeline->end_loop("", stage_seconds);
  exception.rethrow();
}

unsigned Scheduler::threads() const {
  return state_->threads;
}

unsigned Scheduler::all_threads() const {
  return state_->all_threads;
}

void Scheduler::set_film(Film& film) {
  state_->film = &film;
}

void Scheduler::set_commit_callback(CommitCallback callback) {
  state_->on_commit = std::move(callback);
}

const CommitCallback& Scheduler::commit_callback() const {
  return state_->on_commit;
}

}  // namespace kinome

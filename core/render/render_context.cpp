#include "kinome/log.h"
#include "kinome/error.h"
#include "kinome/render_context.h"

#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "base/denormals.h"
#include "image/film_pixels.h"
#include "kinome/work_source.h"
#include "kinome/process_group.h"
#include "kinome/shared_items.h"
#include "render/commits.h"
#include "render/group_pass.h"
#include "render/thread_pool.h"

namespace kinome {
namespace {

using Clock = std::chrono::steady_clock;

/// Reports the progress of a pass. A thread doesn't wait if another one is reporting.
class Progress {
 public:
  Progress(const ProgressCallback& callback, size_t total, size_t done, double begin, double end)
      : callback_(callback), total_(total), begin_(begin), end_(end), done_(done) {}
  void add_done() { report(1 + done_.fetch_add(1, std::memory_order_relaxed)); }
  void report(size_t done) {
    if (!callback_) return;
    // Only the last report waits, so that the end is always reported.
    std::unique_lock lock(mutex_, std::defer_lock);
    if (done == total_) {
      lock.lock();
    } else if (!lock.try_lock()) {
      return;
    }
    if (done <= reported_) return;
    reported_ = done;
    callback_(begin_ + (end_ - begin_) * static_cast<double>(done) / static_cast<double>(total_));
  }

 private:
  const ProgressCallback& callback_;
  const size_t total_;
  const double begin_;
  const double end_;
  std::atomic<size_t> done_;
  std::mutex mutex_;
  size_t reported_ = 0;
};

std::vector<Rect> tiles_of(const Rect& region) {
  std::vector<Rect> tiles;
  for (int y = region.y0; y < region.y1; y += kTileSize) {
    for (int x = region.x0; x < region.x1; x += kTileSize) {
      tiles.push_back(
          {x, y, std::min(x + kTileSize, region.x1), std::min(y + kTileSize, region.y1)});
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

/// Thrown to cancel an item (RenderContext::give_up_if_asked()).
struct ItemCancelled {};

}  // namespace

RenderContext::RenderContext(Options options) : options_(std::move(options)) {
  if (options_.threads == 0) options_.threads = std::max(1u, std::thread::hardware_concurrency());
  stats_.threads = options_.threads;
  all_threads_ = options_.threads;
  if (ProcessGroup* const group = options_.group) {
    stats_.processes = static_cast<unsigned>(group->size());
    uint64_t threads = options_.threads;
    add_up({&threads, 1});
    all_threads_ = static_cast<unsigned>(threads);
  }
  pool_ = std::make_unique<ThreadPool>(options_.threads);
  if (!options_.clock) {
    options_.clock = [start = options_.start] {
      return std::chrono::duration<double>(Clock::now() - start).count();
    };
  }
}

RenderContext::~RenderContext() = default;

void RenderContext::for_each_tile(Film& film, const std::function<void(Tile&)>& fn, int layer) {
  const std::vector<Rect> tiles = tiles_of(film.sampled());
  left_out_.clear();
  if (!gaps_.empty()) {
    for (const Rect& tile : tiles) left_out_.push_back(!is_wanted(tile, film.first_layer() + layer));
  }
  for_each(tiles.size(), [&](size_t index, RenderCounters& counters) {
    std::vector<FilmTile> film_tiles;
    film_tiles.push_back(film.make_tile(tiles[index], layer));
    Tile tile{tiles[index], film_tiles[0], counters};
    fn(tile);
    commit(film, index, std::move(film_tiles));
  });
}

void RenderContext::set_gaps(const Rect& crop, std::vector<std::vector<bool>> gaps) {
  gaps_crop_ = crop;
  gaps_ = std::move(gaps);
}

bool RenderContext::is_wanted(const Rect& pixels, int layer) const {
  if (gaps_.empty()) return true;
  const Rect& crop = gaps_crop_;
  for (int y = std::max(pixels.y0, crop.y0); y < std::min(pixels.y1, crop.y1); ++y) {
    for (int x = std::max(pixels.x0, crop.x0); x < std::min(pixels.x1, crop.x1); ++x) {
      const size_t row = static_cast<size_t>(y - crop.y0) * crop.width();
      if (gaps_[layer][row + (x - crop.x0)]) return true;
    }
  }
  return false;
}

void RenderContext::commit(Film& film, size_t item, std::vector<FilmTile> tiles) {
  if (!is_root() && !commits_) {
    throw std::logic_error("in a group of processes, only items of a for_each are committed");
  }
  if (!is_root()) {
    options_.group->send(Commits::pack(item, std::move(tiles)));
  } else if (commits_) {
    commits_->finish(film, item, std::move(tiles));
  } else {
    add(film, item, tiles);
  }
}

void RenderContext::add(Film& film, size_t item, const std::vector<FilmTile>& tiles) {
  for (const FilmTile& tile : tiles) film.commit(tile);
  if (on_commit_) {
    for (const FilmTile& tile : tiles) {
      const Rect& crop = film.crop();
      const Rect pixels = tile.has_splats() ? crop : intersection(tile.pixels(), crop);
      if (pixels.area() > 0) on_commit_(film, pixels);
    }
  }
  if (work_source_) work_source_->add(film, item, tiles.size());
}

bool RenderContext::is_committed(size_t item) const {
  return (item < left_out_.size() && left_out_[item]) ||
         (work_source_ && work_source_->is_done(item));
}

void RenderContext::give_up_if_asked() const {
  if (options_.group && interrupted()) throw ItemCancelled();
}

/// Returns the items that aren't in the film yet, in the order in which they are processed. The
/// result is the same for all processes of a group. Collective.
std::vector<size_t> RenderContext::items_to_do(size_t count) {
  std::vector<size_t> order = tile_order(count, options_.tile_order_seed);
  if (ProcessGroup* const group = options_.group) {
    // Only the root knows which items are in the film.
    std::string done;
    for (size_t item = 0; is_root() && work_source_ && item < count; ++item) {
      done.push_back(is_committed(item) ? 1 : 0);
    }
    done = group->broadcast(done, "decisions");
    if (!is_root()) left_out_.assign(done.begin(), done.end());
  }
  std::erase_if(order, [&](size_t item) { return is_committed(item); });
  return order;
}

void RenderContext::for_each(size_t count, const std::function<void(size_t, RenderCounters&)>& fn,
                             SharedItems* shared) {
  ProcessGroup* const group = options_.group;
  if (work_source_) work_source_->begin_pass(count);
  std::vector<size_t> order = items_to_do(count);
  const size_t to_do = order.size();
  const bool stays = group && shared && !shared->stay().empty();
  if (stays) {
    std::erase_if(order, [&](size_t item) { return shared->stay()[item] != group->rank(); });
  }
  const auto threads = static_cast<unsigned>(std::clamp<size_t>(order.size(), 1, options_.threads));
  const auto overall = [&](double progress) {
    return pass_begin_ + (pass_end_ - pass_begin_) * progress;
  };
  Progress progress(options_.progress, count, count - to_do, overall(progress_begin_),
                    overall(progress_end_));
  FirstException exception;
  std::vector<RenderCounters> counters(threads);
  std::atomic<size_t> next{0};
  if (stats_.first_tile_seconds == 0) stats_.first_tile_seconds = seconds();
  commits_ = std::make_unique<Commits>(*this);
  std::optional<GroupPass> pass;
  if (group) {
    pass.emplace(*group, shared, count);
    group->begin_pass([&](int, std::string_view bytes) {
      const DenormalGuard guard;
      commits_->receive(*film_, bytes);
    });
    group_at_work_ = true;
  }
  pool_->run(threads, [&](unsigned thread) {
    while (!exception.any() && !cancelled()) {
      const size_t turn =
          group && !stays ? group->next() : next.fetch_add(1, std::memory_order_relaxed);
      if (turn >= order.size()) return;
      const size_t index = order[turn];
      try {
        fn(index, counters[thread]);
        if (pass) pass->add_finished(index);
        if (group) {
          // The progress of all processes is about the number of items distributed so far.
          progress.report(count - to_do + (turn + 1) * to_do / order.size());
        } else {
          progress.add_done();
        }
      } catch (const ItemCancelled&) {
        break;
      } catch (...) {
        exception.capture(index);
      }
    }
    if (group && (exception.any() || cancelled())) group->stop();
  });
  RenderCounters sum;
  for (const RenderCounters& c : counters) sum.add(c);
  // Save the checkpoint before waiting for the other processes: they may have been killed, and this
  // one may be soon.
  if (group && work_source_ && is_interrupted_here()) commits_->save(*work_source_);
  try {
    if (pass) {
      const GroupPass::Outcome outcome =
          pass->end(is_interrupted_here(), is_late_here(), std::move(sum), exception);
      group_at_work_ = false;
      group_interrupted_ = group_interrupted_ || outcome.interrupted;
      group_late_ = outcome.late;
      sum = outcome.counters;
      if (!cancelled()) progress.report(count);
    }
    stats_.counters.add(sum);
    exception.rethrow();
  } catch (...) {
    group_at_work_ = false;
    if (work_source_ && commits_->film()) work_source_->abandon();
    end_pass();
    throw;
  }
  // Close the checkpoint before the remaining items are added: a resumed render must add items in
  // their order, and end_pass() doesn't.
  if (work_source_ && commits_->film() && cancelled()) work_source_->close(*commits_->film());
  end_pass();
}

void RenderContext::end_pass() {
  left_out_.clear();
  commits_->commit_rest();
  commits_.reset();
}

void RenderContext::set_progress_range(double begin, double end) {
  progress_begin_ = begin;
  progress_end_ = end;
}

void RenderContext::begin_pass(uint64_t index, double begin, double end) {
  pass_ = index;
  pass_begin_ = begin;
  pass_end_ = end;
  set_progress_range(0, 1);
}

void RenderContext::parallel_for(size_t count, const std::function<void(size_t)>& fn) const {
  if (count == 0) return;
  const auto threads = static_cast<unsigned>(std::min<size_t>(count, options_.threads));
  FirstException exception;
  std::atomic<size_t> next{0};
  // Blocks reduce the cost of the counter for short bodies, and are small enough to balance long
  // ones.
  const size_t block = std::max<size_t>(1, count / (size_t{64} * threads));
  pool_->run(threads, [&](unsigned) {
    while (!exception.any()) {
      const size_t first = next.fetch_add(block, std::memory_order_relaxed);
      if (first >= count) return;
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
  exception.rethrow();
}

void RenderContext::skip(std::string what, std::string why) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  for (const Skipped& s : stats_.skipped) {
    if (s.what == what && s.why == why) return;
  }
  stats_.skipped.push_back({std::move(what), std::move(why)});
}

WorkSource::~WorkSource() = default;

void warn_without_emitters(const Scene& scene) {
  if (!scene.emitters().empty()) return;
  log_warn(
      Error(Location{scene.file()}, "the scene has no emitter: the image will be black").what());
}

}  // namespace kinome

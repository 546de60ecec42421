#include "kinome/render_context.h"

#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "image/film_pixels.h"
#include "kinome/checkpoint.h"
#include "render/thread_pool.h"

namespace kinome {
namespace {

using Clock = std::chrono::steady_clock;

/// The exception of the lowest index among those thrown, and whether there is any.
class FirstException {
 public:
  bool any() const { return any_.load(std::memory_order_relaxed); }
  void capture(size_t index) {
    const std::lock_guard lock(mutex_);
    if (!exception_ || index < index_) {
      exception_ = std::current_exception();
      index_ = index;
    }
    any_.store(true, std::memory_order_relaxed);
  }
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<bool> any_{false};
  std::mutex mutex_;
  size_t index_ = 0;
  std::exception_ptr exception_;
};

/// Commits tiles to a film in the order of their indices, whatever order they are finished in.
class Sequencer {
 public:
  Sequencer(RenderContext& context, Film& film) : context_(context), film_(film) {}
  void finish(size_t index, FilmTile tile) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(index, std::move(tile));
    while (!waiting_.empty()) {
      // Those that a resumed render brought along will not come.
      while (context_.is_committed(next_)) ++next_;
      const auto first = waiting_.begin();
      if (first->first != next_) break;
      context_.commit(film_, next_, {&first->second});
      waiting_.erase(first);
      ++next_;
    }
  }
  /// What waits for a tile that will not come any more.
  void commit_rest() {
    for (const auto& [index, tile] : waiting_) film_.commit(tile);
    waiting_.clear();
  }

 private:
  RenderContext& context_;
  Film& film_;
  std::mutex mutex_;
  std::map<size_t, FilmTile> waiting_;
  size_t next_ = 0;
};

/// Tells how far a pass is. A thread that finds another one telling does not wait for it.
class Progress {
 public:
  Progress(const ProgressCallback& callback, size_t total, size_t done, double begin, double end)
      : callback_(callback), total_(total), begin_(begin), end_(end), done_(done) {}
  void one_done() {
    const size_t done = 1 + done_.fetch_add(1, std::memory_order_relaxed);
    if (!callback_) return;
    // The last one waits: the end is always told.
    std::unique_lock lock(mutex_, std::defer_lock);
    if (done == total_) {
      lock.lock();
    } else if (!lock.try_lock()) {
      return;
    }
    if (done <= told_) return;
    told_ = done;
    callback_(begin_ + (end_ - begin_) * static_cast<double>(done) / static_cast<double>(total_));
  }

 private:
  const ProgressCallback& callback_;
  const size_t total_;
  const double begin_;
  const double end_;
  std::atomic<size_t> done_;
  std::mutex mutex_;
  size_t told_ = 0;
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

/// Order in which `count` tiles are handed out: their own for seed 0, else shuffled.
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

}  // namespace

RenderContext::RenderContext(Options options) : options_(std::move(options)) {
  if (options_.threads == 0) options_.threads = std::max(1u, std::thread::hardware_concurrency());
  stats_.threads = options_.threads;
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
  Sequencer sequencer(*this, film);
  left_out_.clear();
  if (!gaps_.empty()) {
    for (const Rect& tile : tiles) left_out_.push_back(!is_wanted(tile, film.first_layer() + layer));
  }
  try {
    for_each(tiles.size(), [&](size_t index, RenderCounters& counters) {
      FilmTile film_tile = film.make_tile(tiles[index], layer);
      Tile tile{tiles[index], film_tile, counters};
      fn(tile);
      sequencer.finish(index, std::move(film_tile));
    });
  } catch (...) {
    left_out_.clear();
    if (checkpoint_) checkpoint_->abandon();
    sequencer.commit_rest();
    throw;
  }
  // Sums are to be made in the tiles' order whenever the render goes on: no checkpoint has the
  // rest.
  if (checkpoint_ && cancelled()) checkpoint_->close(film);
  sequencer.commit_rest();
  left_out_.clear();
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

void RenderContext::commit(Film& film, size_t item, std::initializer_list<const FilmTile*> tiles) {
  const std::lock_guard lock(commit_mutex_);
  uint64_t commits = 0;
  for (const FilmTile* tile : tiles) {
    if (!tile) continue;
    film.commit(*tile);
    ++commits;
  }
  if (on_commit_) {
    for (const FilmTile* tile : tiles) {
      if (!tile) continue;
      const Rect& crop = film.crop();
      const Rect pixels = tile->has_splats() ? crop : intersection(tile->pixels(), crop);
      if (pixels.area() > 0) on_commit_(film, pixels);
    }
  }
  if (checkpoint_) checkpoint_->add(film, item, commits);
}

bool RenderContext::is_committed(size_t item) const {
  return (item < left_out_.size() && left_out_[item]) ||
         (checkpoint_ && checkpoint_->is_done(item));
}

double RenderContext::decide(const std::function<double()>& decide) {
  return checkpoint_ ? checkpoint_->decide(decide) : decide();
}

void RenderContext::for_each(size_t count, const std::function<void(size_t, RenderCounters&)>& fn) {
  std::vector<size_t> order = tile_order(count, options_.tile_order_seed);
  if (checkpoint_) {
    checkpoint_->begin_pass(count);
  }
  std::erase_if(order, [&](size_t item) { return is_committed(item); });
  const auto threads = static_cast<unsigned>(std::clamp<size_t>(order.size(), 1, options_.threads));
  const auto told = [&](double share) { return pass_begin_ + (pass_end_ - pass_begin_) * share; };
  Progress progress(options_.progress, count, count - order.size(), told(progress_begin_),
                    told(progress_end_));
  FirstException exception;
  std::vector<RenderCounters> counters(threads);
  std::atomic<size_t> next{0};
  if (stats_.first_tile_seconds == 0) stats_.first_tile_seconds = seconds();
  pool_->run(threads, [&](unsigned thread) {
    while (!exception.any() && !cancelled()) {
      const size_t turn = next.fetch_add(1, std::memory_order_relaxed);
      if (turn >= order.size()) return;
      const size_t index = order[turn];
      try {
        fn(index, counters[thread]);
        progress.one_done();
      } catch (...) {
        exception.capture(index);
      }
    }
  });
  for (const RenderCounters& c : counters) stats_.counters.add(c);
  exception.rethrow();
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
  // Blocks keep the counter's cost out of short bodies, and are small enough to balance long ones.
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

}  // namespace kinome

#pragma once

#include <atomic>
#include <mutex>

#include "kinome/render_options.h"

namespace kinome {

/// Reports the progress of a loop. A thread doesn't wait if another one is reporting.
class LoopProgress {
 public:
  /// The callback, which may be empty, gets fractions from `begin` to `end`. It must outlive this
  /// object.
  LoopProgress(const ProgressCallback& callback, size_t total, size_t done, double begin,
               double end)
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
  const double begin_, end_;
  std::atomic<size_t> done_;
  std::mutex mutex_;
  size_t reported_ = 0;
};

}  // namespace kinome

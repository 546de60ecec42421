#pragma once

#include <cstdint>

#include "kinome/timeline.h"

namespace kinome {

/// Adds the time of its lifetime to a timeline as an item of a thread. Does nothing if the timeline
/// is nullptr.
class ItemTimer {
 public:
  ItemTimer(Timeline* timeline, unsigned thread, uint64_t item)
      : timeline_(timeline), thread_(thread), item_(item) {
    if (!timeline_) return;
    current() = this;
    begin_ = timeline_->now();
  }
  ItemTimer(const ItemTimer&) = delete;
  ItemTimer& operator=(const ItemTimer&) = delete;
  ~ItemTimer() {
    if (!timeline_) return;
    const double end = timeline_->now();
    const bool commits = commit_begin_ >= 0;
    timeline_->add(thread_, item_, begin_, commits ? commit_begin_ : end, false);
    if (commits) timeline_->add(thread_, item_, commit_begin_, end, true);
    current() = nullptr;
  }

  /// Records that the item's commit begins; it lasts until the end of the item.
  void begin_commit() {
    if (commit_begin_ < 0) commit_begin_ = timeline_->now();
  }
  /// Timer of the item that this thread runs, or nullptr.
  static ItemTimer*& current() {
    static thread_local ItemTimer* timer = nullptr;
    return timer;
  }

 private:
  Timeline* const timeline_;
  const unsigned thread_;
  const uint64_t item_;
  double begin_ = 0, commit_begin_ = -1;
};

}  // namespace kinome

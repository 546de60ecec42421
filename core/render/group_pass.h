#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <string>
#include <vector>

#include "kinome/stats.h"

namespace kinome {

class ProcessGroup;
class SharedItems;

/// Keeps the exception of the item with the lowest index. Thread-safe.
class FirstException {
 public:
  bool any() const { return any_.load(std::memory_order_relaxed); }
  void capture(size_t item);
  /// Rethrows the exception, if any. Call it after all threads have finished.
  void rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }
  size_t item() const { return item_; }
  std::string message() const;

 private:
  std::atomic<bool> any_{false};
  std::mutex mutex_;
  size_t item_ = 0;
  std::exception_ptr exception_;
};

/// Exchanges results, counters and errors between the processes of a group at the end of a pass.
class GroupPass {
 public:
  /// The arguments must outlive this object. `shared` may be nullptr.
  GroupPass(ProcessGroup& group, SharedItems* shared, size_t items)
      : group_(group), shared_(shared), items_(items) {}

  /// Records that this process has finished an item. Thread-safe.
  void add_finished(size_t item);

  struct Outcome {
    bool interrupted = false, late = false;  ///< true if any process is
    RenderCounters counters;                 ///< sum over all processes
  };
  /// Ends the group's pass, and stores the results of other processes with SharedItems::transfer().
  /// If any process has an exception, all throw an AgreedError with the message of the lowest item.
  /// Collective.
  Outcome end(bool interrupted, bool late, RenderCounters counters,
              const FirstException& exception);

 private:
  std::string report(bool interrupted, bool late, RenderCounters& counters,
                     const FirstException& exception) const;

  ProcessGroup& group_;
  SharedItems* const shared_;
  const size_t items_;
  std::mutex mutex_;
  std::vector<size_t> finished_;
};

}  // namespace kinome

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

/// The exception of the lowest item among those thrown, and whether there is any. Thread-safe.
class FirstException {
 public:
  bool any() const { return any_.load(std::memory_order_relaxed); }
  void capture(size_t item);
  /// After all threads.
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

/// What the processes of a group tell each other at the end of a pass.
class GroupPass {
 public:
  /// All must outlive it. `shared` may be nullptr.
  GroupPass(ProcessGroup& group, SharedItems* shared, size_t items)
      : group_(group), shared_(shared), items_(items) {}

  /// An item was made here. Thread-safe.
  void made(size_t item);

  struct Outcome {
    bool interrupted = false, late = false;  ///< by any process
    RenderCounters counters;                 ///< of all
  };
  /// Collective. Ends the group's pass, and puts what other processes made where it belongs. Where
  /// any process has an exception, all throw an AgreedError, of what that of the lowest item says.
  Outcome end(bool interrupted, bool late, RenderCounters counters,
              const FirstException& exception);

 private:
  std::string report(bool interrupted, bool late, RenderCounters& counters,
                     const FirstException& exception) const;

  ProcessGroup& group_;
  SharedItems* const shared_;
  const size_t items_;
  std::mutex mutex_;
  std::vector<size_t> made_;
};

}  // namespace kinome

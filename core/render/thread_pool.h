#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kinome {

/// Pool of threads that sleep until there is work. Create it well before the work: a new thread
/// starts on the processor of its creator, and Linux may take milliseconds to move it to an idle
/// one. A woken thread starts on the processor where it fell asleep, if that is idle. Each thread
/// is therefore first moved to a processor of its own; later it may run anywhere.
class ThreadPool {
 public:
  /// `threads` includes the thread that calls run().
  explicit ThreadPool(unsigned threads);
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  /// Calls work(0) on this thread, and work(1), work(2) ... on at most `threads` - 1 others, each
  /// with denormals flushed. Threads that haven't started when work(0) returns don't start, so
  /// `work` must process items from a shared queue until none is left. Within `work`, or while
  /// another thread uses the pool, only work(0) is called. `work` must not throw.
  void run(unsigned threads, const std::function<void(unsigned index)>& work);

 private:
  void serve();
  void stop();

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(unsigned)>* work_ = nullptr;  ///< nullptr while there is no work
  unsigned next_ = 0;                                    ///< index of the next thread to start
  unsigned end_ = 0;
  unsigned running_ = 0;  ///< number of running threads, without the caller of run()
  bool stops_ = false;
  std::vector<std::jthread> others_;
};

}  // namespace kinome

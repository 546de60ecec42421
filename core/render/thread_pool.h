#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kinome {

/// Threads that sleep until there is work. To be made ahead of it: a new thread begins on the
/// processor of the one that made it, and Linux may take milliseconds to move it to an idle one.
/// One that is woken begins where it fell asleep, if that processor is idle: each is sent to one of
/// its own first, and may go anywhere from then on.
class ThreadPool {
 public:
  /// `threads`: with the one that calls run().
  explicit ThreadPool(unsigned threads);
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  /// Calls work(0) on this thread, and work(1), work(2) ... on at most `threads` - 1 others, each
  /// with denormals flushed. Others that have not begun when this one is through don't any more:
  /// `work` is to take what there is to do piece by piece, until nothing is left. From within
  /// `work`, or while another thread has the pool at work, this thread is alone. `work` must not
  /// throw.
  void run(unsigned threads, const std::function<void(unsigned index)>& work);

 private:
  void serve();
  void stop();

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(unsigned)>* work_ = nullptr;  ///< nullptr: there is none
  unsigned next_ = 0;                                    ///< index of the next that begins
  unsigned end_ = 0;
  unsigned running_ = 0;  ///< of the others
  bool stops_ = false;
  std::vector<std::jthread> others_;
};

}  // namespace kinome

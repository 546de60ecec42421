#include "render/thread_pool.h"

#include "base/denormals.h"
#include "kinome/alternate_stack.h"

#if defined(__linux__)
#include <sched.h>
#endif

namespace kinome {
namespace {

#if defined(__linux__)
int this_processor() {
  return sched_getcpu();
}

/// Moves this thread to the processor that comes `processors` after `from` among the allowed ones.
/// Afterwards, the thread may run on any allowed processor again.
void move_on(int from, unsigned processors) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  const auto count = static_cast<unsigned>(CPU_COUNT(&allowed));
  if (from < 0 || count < 2 || processors % count == 0) return;
  int to = from;
  for (unsigned left = processors % count; left > 0;) {
    to = (to + 1) % CPU_SETSIZE;
    if (CPU_ISSET(to, &allowed)) --left;
  }
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(to, &one);
  if (sched_setaffinity(0, sizeof one, &one) == 0) sched_setaffinity(0, sizeof allowed, &allowed);
}
#else
int this_processor() {
  return -1;
}
void move_on(int, unsigned) {}
#endif

}  // namespace

ThreadPool::ThreadPool(unsigned threads) {
  others_.reserve(threads);
  try {
    const int here = this_processor();
    for (unsigned i = 1; i < threads; ++i) {
      others_.emplace_back([this, here, i] {
        move_on(here, i);
        serve();
      });
    }
  } catch (...) {
    stop();
    throw;
  }
}

ThreadPool::~ThreadPool() {
  stop();
}

void ThreadPool::stop() {
  const std::lock_guard lock(mutex_);
  stops_ = true;
  wake_.notify_all();
}

void ThreadPool::run(unsigned threads, const std::function<void(unsigned index)>& work) {
  const AlternateStack stack;
  const DenormalGuard guard;
  bool uses_pool = false;
  if (threads > 1) {
    const std::lock_guard lock(mutex_);
    uses_pool = !work_;
    if (uses_pool) work_ = &work, next_ = 1, end_ = threads;
  }
  if (uses_pool) {
    for (unsigned i = 1; i < threads; ++i) wake_.notify_one();
  }
  work(0);
  if (!uses_pool) return;
  std::unique_lock lock(mutex_);
  end_ = next_;
  done_.wait(lock, [this] { return running_ == 0; });
  work_ = nullptr;
}

void ThreadPool::serve() {
  const AlternateStack stack;
  const DenormalGuard guard;
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stops_ || next_ < end_; });
    if (stops_) return;
    const unsigned index = next_++;
    const auto& work = *work_;
    ++running_;
    lock.unlock();
    work(index);
    lock.lock();
    if (--running_ == 0) done_.notify_one();
  }
}

}  // namespace kinome

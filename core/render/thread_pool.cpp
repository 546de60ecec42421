#include "render/thread_pool.h"

#include "base/denormals.h"
#include "kinome/alternate_stack.h"

namespace kinome {

ThreadPool::ThreadPool(unsigned threads) {
  others_.reserve(threads);
  try {
    for (unsigned i = 1; i < threads; ++i) others_.emplace_back([this] { serve(); });
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
  bool is_mine = false;
  if (threads > 1) {
    const std::lock_guard lock(mutex_);
    is_mine = !work_;
    if (is_mine) work_ = &work, next_ = 1, end_ = threads;
  }
  if (is_mine) {
    for (unsigned i = 1; i < threads; ++i) wake_.notify_one();
  }
  work(0);
  if (!is_mine) return;
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

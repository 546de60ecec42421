#include "scene_xml/objects/read_ahead.h"

#include <system_error>
#include <utility>

#include "base/read_files.h"
#include "kinome/alternate_stack.h"

namespace kinome::loader {

std::shared_ptr<Object> ReadAhead::Pending::take() {
  Outcome outcome = outcome_.get();
  for (const LogCapture::Message& message : outcome.messages) LogCapture::log(message);
  if (outcome.error) std::rethrow_exception(outcome.error);
  return outcome.object;
}

ReadAhead::~ReadAhead() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

ReadAhead::Pending ReadAhead::begin(Make make, uint64_t bytes) {
  ReadFiles* const owner = ReadFiles::recorded_by_this_thread();
  std::packaged_task<Pending::Outcome()> task([owner, make = std::move(make)] {
    const ReadFiles::Recording recording(owner);
    LogCapture capture;
    Pending::Outcome outcome;
    try {
      outcome.object = make();
    } catch (...) {
      outcome.error = std::current_exception();
    }
    outcome.messages = capture.take();
    return outcome;
  });
  Pending pending;
  pending.outcome_ = task.get_future();
  if (workers_.size() < threads_) {
    try {
      workers_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {
      // The threads that could be started do all work.
    }
  }
  if (workers_.empty()) {
    task();
    return pending;
  }
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back({std::move(task), bytes});
  }
  wake_.notify_one();
  return pending;
}

void ReadAhead::serve() {
  const AlternateStack stack;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] {
      return stops_ || (!queue_.empty() && in_use_.admits(queue_.front().bytes));
    });
    if (stops_) return;
    Item item = std::move(queue_.front());
    queue_.pop_front();
    in_use_.begin(item.bytes);
    lock.unlock();
    item.task();
    lock.lock();
    in_use_.end(item.bytes);
    wake_.notify_all();
  }
}

}  // namespace kinome::loader

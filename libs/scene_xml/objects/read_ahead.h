#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/log_capture.h"
#include "kinome/object.h"
#include "scene_xml/objects/memory_in_use.h"

namespace kinome::loader {

/// Creates objects in background threads. An object's messages and exception are kept until it is
/// taken, so that they come in the order in which the objects are taken.
class ReadAhead {
 public:
  using Make = std::function<std::shared_ptr<Object>()>;

  /// An object that is being made.
  class Pending {
   public:
    /// Waits for the object, logs its messages, and rethrows its exception.
    std::shared_ptr<Object> take();

   private:
    friend class ReadAhead;
    struct Outcome {
      std::shared_ptr<Object> object;
      std::exception_ptr error;
      std::vector<LogCapture::Message> messages;
    };
    std::future<Outcome> outcome_;
  };

  /// Starts the threads when there is work for them, at most `threads`. Without threads, begin()
  /// makes the object itself.
  explicit ReadAhead(unsigned threads) : threads_(threads) {}
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;
  /// Waits for the objects that are being made. Those not yet begun are dropped.
  ~ReadAhead();

  /// Queues an object. What `make` refers to must outlive this ReadAhead. `bytes` is an estimate of
  /// the memory that `make` takes: the object waits until MemoryInUse admits it.
  Pending begin(Make make, uint64_t bytes = 0);

 private:
  struct Item {
    std::packaged_task<Pending::Outcome()> task;
    uint64_t bytes;
  };
  void serve();

  const unsigned threads_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_;
  MemoryInUse in_use_;
  bool stops_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace kinome::loader

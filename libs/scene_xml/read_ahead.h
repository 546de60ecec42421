#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/log_capture.h"
#include "kinome/object.h"

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

  /// Queues an object. What `make` refers to must outlive this ReadAhead.
  Pending begin(Make make);

 private:
  void serve();

  const unsigned threads_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::packaged_task<Pending::Outcome()>> queue_;
  bool stops_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace kinome::loader

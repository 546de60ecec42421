#pragma once

#include <functional>
#include <string>

#include "kinome/export.h"

namespace kinome {

/// Receives all warnings of log_warn() during its lifetime, independent of the log level and in
/// addition to stderr. For programs that show warnings elsewhere.
class KINOME_EXPORT LogListener {
 public:
  /// Calls `callback` for each warning, on any thread, by one thread at a time. `callback` must not
  /// log, nor create or destroy a listener.
  explicit LogListener(std::function<void(const std::string& warning)> callback);
  ~LogListener();
  LogListener(const LogListener&) = delete;
  LogListener& operator=(const LogListener&) = delete;

 private:
  std::function<void(const std::string& warning)> callback_;
  friend void notify_listeners(const std::string& warning);
};

}  // namespace kinome

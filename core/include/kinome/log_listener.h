#pragma once

#include <functional>
#include <string>

#include "kinome/export.h"

namespace kinome {

/// Receives all warnings of log_warn() during its lifetime, independent of the log level and in
/// addition to stderr. For programs that show warnings elsewhere.
class KINOME_EXPORT LogListener {
 public:
  /// Calls `hear` for each warning, on any thread, by one thread at a time. `hear` must not log,
  /// nor create or destroy a listener.
  explicit LogListener(std::function<void(const std::string& warning)> hear);
  ~LogListener();
  LogListener(const LogListener&) = delete;
  LogListener& operator=(const LogListener&) = delete;

 private:
  std::function<void(const std::string& warning)> hear_;
  friend void tell_listeners(const std::string& warning);
};

}  // namespace kinome

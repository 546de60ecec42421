#pragma once

#include <functional>
#include <string>

#include "kinome/export.h"

namespace kinome {

/// Is told all warnings for as long as it lives, as log_warn() has them, beside stderr and whatever
/// the log level is: for programs that show them elsewhere.
class KINOME_EXPORT LogListener {
 public:
  /// `hear` may be called by any thread, by one at a time. It must not log, nor make or destroy a
  /// listener.
  explicit LogListener(std::function<void(const std::string& warning)> hear);
  ~LogListener();
  LogListener(const LogListener&) = delete;
  LogListener& operator=(const LogListener&) = delete;

 private:
  std::function<void(const std::string& warning)> hear_;
  friend void tell_listeners(const std::string& warning);
};

}  // namespace kinome

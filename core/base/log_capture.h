#pragma once

#include <string>
#include <vector>

#include "kinome/log.h"

namespace kinome {

/// Keeps the messages that its thread logs during its lifetime, instead of printing them.
class LogCapture {
 public:
  struct Message {
    LogLevel level;
    std::string text;
    std::string file = {};  ///< of a message that is logged once per file
  };

  LogCapture();
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  /// Logs a message that was kept, or keeps it if this thread has a LogCapture.
  static void log(const Message& message);
  std::vector<Message> take() { return std::move(kept_); }

 private:
  LogCapture* const outer_;
  std::vector<Message> kept_;
};

}  // namespace kinome

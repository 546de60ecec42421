#include "kinome/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace kinome {
namespace {

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kQuiet:
      return spdlog::level::err;
    case LogLevel::kWarn:
      return spdlog::level::warn;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kDebug:
      return spdlog::level::debug;
  }
  return spdlog::level::warn;
}

/// Never destroyed: threads and static destructors may log until the very end.
spdlog::logger& logger() {
  static spdlog::logger* const instance = [] {
    auto* created = new spdlog::logger("kinome", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    created->set_pattern("kinome: %v");
    created->set_level(spdlog_level(LogLevel::kWarn));
    created->flush_on(spdlog::level::debug);
    return created;
  }();
  return *instance;
}

}  // namespace

void set_log_level(LogLevel level) {
  logger().set_level(spdlog_level(level));
}

LogLevel log_level() {
  switch (logger().level()) {
    case spdlog::level::warn:
      return LogLevel::kWarn;
    case spdlog::level::info:
      return LogLevel::kInfo;
    case spdlog::level::debug:
      return LogLevel::kDebug;
    default:
      return LogLevel::kQuiet;
  }
}

void log_warn(const std::string& message) {
  logger().warn("warning: {}", message);
}
void log_info(const std::string& message) {
  logger().info("{}", message);
}
void log_debug(const std::string& message) {
  logger().debug("{}", message);
}

}  // namespace kinome

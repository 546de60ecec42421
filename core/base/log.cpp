#include "kinome/log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "base/log_once.h"
#include "kinome/error.h"
#include "kinome/log_listener.h"

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

/// The warnings that were told since the first WarningsOnce of those that live. Never destroyed,
/// either.
struct Told {
  std::mutex mutex;
  int scopes = 0;
  std::set<std::string> warnings;
  std::set<std::string> files;  ///< of log_unused()
};
Told& told() {
  static Told* const instance = new Told;
  return *instance;
}

bool is_told_already(const std::string& warning) {
  const std::lock_guard lock(told().mutex);
  return told().scopes > 0 && !told().warnings.insert(warning).second;
}

/// Those that live. Never destroyed, either.
struct Listeners {
  std::mutex mutex;
  std::vector<LogListener*> all;
};
Listeners& listeners() {
  static Listeners* const instance = new Listeners;
  return *instance;
}

}  // namespace

void tell_listeners(const std::string& warning) {
  const std::lock_guard lock(listeners().mutex);
  for (LogListener* const listener : listeners().all) listener->hear_(warning);
}

LogListener::LogListener(std::function<void(const std::string& warning)> hear)
    : hear_(std::move(hear)) {
  const std::lock_guard lock(listeners().mutex);
  listeners().all.push_back(this);
}

LogListener::~LogListener() {
  const std::lock_guard lock(listeners().mutex);
  std::erase(listeners().all, this);
}

WarningsOnce::WarningsOnce(std::set<std::string>* seen) : seen_(seen) {
  const std::lock_guard lock(told().mutex);
  if (told().scopes++ > 0) seen_ = nullptr;
  if (seen_) told().warnings = *seen_;
}

WarningsOnce::~WarningsOnce() {
  const std::lock_guard lock(told().mutex);
  if (seen_) seen_->insert(told().warnings.begin(), told().warnings.end());
  if (--told().scopes == 0) told().warnings.clear();
}

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
  if (is_told_already(message)) return;
  logger().warn("warning: {}", message);
  tell_listeners(message);
}
void log_info(const std::string& message) {
  logger().info("{}", message);
}
void log_debug(const std::string& message) {
  logger().debug("{}", message);
}

void log_unused(const std::string& file, const std::vector<std::string>& what) {
  constexpr size_t kMostTold = 20;
  if (what.empty() || log_level() < LogLevel::kInfo) return;
  {
    const std::lock_guard lock(told().mutex);
    if (!told().files.insert(file).second) return;
  }
  const size_t count = std::min(what.size(), kMostTold);
  const std::string rest =
      what.size() > count ? fmt::format(" and {} more", what.size() - count) : "";
  // An Error's text is one line, whatever names a file has.
  log_info(Error(Location{file},
                 fmt::format("not used: {}{}",
                             fmt::join(what.begin(), what.begin() + static_cast<long>(count), ", "),
                             rest))
               .what());
}

}  // namespace kinome

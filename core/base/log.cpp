#include "kinome/log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "base/log_capture.h"
#include "base/log_once.h"
#include "kinome/error.h"
#include "kinome/log_listener.h"

namespace kinome {
namespace {

/// Returns spdlog's level: err, warn, info or debug, which have descending numbers.
spdlog::level::level_enum spdlog_level(LogLevel level) {
  return static_cast<spdlog::level::level_enum>(spdlog::level::err - static_cast<int>(level));
}

/// Never destroyed, because threads and static destructors may log until the process ends.
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

/// Messages logged while at least one WarningsOnce exists. Never destroyed, either.
struct LoggedMessages {
  std::mutex mutex;
  int scopes = 0;  ///< number of existing WarningsOnce
  std::set<std::string> warnings;
  std::set<std::string> files;  ///< files of log_unused()
};
LoggedMessages& logged() {
  static LoggedMessages* const instance = new LoggedMessages;
  return *instance;
}

bool is_repeated(const std::string& warning) {
  const std::lock_guard lock(logged().mutex);
  return logged().scopes > 0 && !logged().warnings.insert(warning).second;
}

bool is_first_of_file(const std::string& file) {
  const std::lock_guard lock(logged().mutex);
  return logged().files.insert(file).second;
}

thread_local LogCapture* capture = nullptr;

/// All existing listeners. Never destroyed, either.
struct Listeners {
  std::mutex mutex;
  std::vector<LogListener*> all;
};
Listeners& listeners() {
  static Listeners* const instance = new Listeners;
  return *instance;
}

}  // namespace

void notify_listeners(const std::string& warning) {
  const std::lock_guard lock(listeners().mutex);
  for (LogListener* const listener : listeners().all) listener->callback_(warning);
}

LogListener::LogListener(std::function<void(const std::string& warning)> callback)
    : callback_(std::move(callback)) {
  const std::lock_guard lock(listeners().mutex);
  listeners().all.push_back(this);
}

LogListener::~LogListener() {
  const std::lock_guard lock(listeners().mutex);
  std::erase(listeners().all, this);
}

WarningsOnce::WarningsOnce(std::set<std::string>* seen) : seen_(seen) {
  const std::lock_guard lock(logged().mutex);
  if (logged().scopes++ > 0) seen_ = nullptr;
  if (seen_) logged().warnings = *seen_;
}

WarningsOnce::~WarningsOnce() {
  const std::lock_guard lock(logged().mutex);
  if (seen_) seen_->insert(logged().warnings.begin(), logged().warnings.end());
  if (--logged().scopes == 0) logged().warnings.clear();
}

void set_log_level(LogLevel level) {
  logger().set_level(spdlog_level(level));
}

LogLevel log_level() {
  return static_cast<LogLevel>(spdlog::level::err - logger().level());
}

LogCapture::LogCapture() : outer_(capture) {
  capture = this;
}

LogCapture::~LogCapture() {
  capture = outer_;
}

void LogCapture::log(const Message& message) {
  if (capture) {
    capture->kept_.push_back(message);
  } else if (!message.file.empty() && !is_first_of_file(message.file)) {
    return;
  } else if (message.level == LogLevel::kInfo) {
    logger().info("{}", message.text);
  } else if (message.level == LogLevel::kDebug) {
    logger().debug("{}", message.text);
  } else if (!is_repeated(message.text)) {
    logger().warn("warning: {}", message.text);
    notify_listeners(message.text);
  }
}

void log_warn(const std::string& message) {
  LogCapture::log({LogLevel::kWarn, message});
}
void log_info(const std::string& message) {
  LogCapture::log({LogLevel::kInfo, message});
}
void log_debug(const std::string& message) {
  LogCapture::log({LogLevel::kDebug, message});
}

void log_unused(const std::string& file, const std::vector<std::string>& what) {
  constexpr size_t kMaxListed = 20;
  if (what.empty() || log_level() < LogLevel::kInfo) return;
  const size_t count = std::min(what.size(), kMaxListed);
  const std::string rest =
      what.size() > count ? fmt::format(" and {} more", what.size() - count) : "";
  // Error replaces line breaks in the file's names.
  const std::string list =
      fmt::format("{}", fmt::join(what.begin(), what.begin() + static_cast<long>(count), ", "));
  LogCapture::log(
      {LogLevel::kInfo, Error(Location{file}, "not used: " + list + rest).what(), file});
}

}  // namespace kinome

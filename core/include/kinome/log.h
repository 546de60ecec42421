#pragma once

#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

enum class LogLevel { kQuiet, kWarn, kInfo, kDebug };

/// Logging to stderr, through spdlog. Thread-safe.
KINOME_EXPORT void set_log_level(LogLevel level);
KINOME_EXPORT LogLevel log_level();
KINOME_EXPORT void log_warn(const std::string& message);
KINOME_EXPORT void log_info(const std::string& message);
KINOME_EXPORT void log_debug(const std::string& message);
/// Logs on info level which contents of a file are not used: "FILE: not used: A, B". Logs only once
/// per file, and nothing if `what` is empty.
KINOME_EXPORT void log_unused(const std::string& file, const std::vector<std::string>& what);

}  // namespace kinome

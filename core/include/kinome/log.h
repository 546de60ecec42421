#pragma once

#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

enum class LogLevel { kQuiet, kWarn, kInfo, kDebug };

/// Log lines go to stderr, through spdlog. Thread-safe.
KINOME_EXPORT void set_log_level(LogLevel level);
KINOME_EXPORT LogLevel log_level();
KINOME_EXPORT void log_warn(const std::string& message);
KINOME_EXPORT void log_info(const std::string& message);
KINOME_EXPORT void log_debug(const std::string& message);
/// What a reader leaves aside of what a file holds, as by log_info: "FILE: not used: A, B". Told
/// but once of a file, however often it is read; nothing where `what` is empty.
KINOME_EXPORT void log_unused(const std::string& file, const std::vector<std::string>& what);

}  // namespace kinome

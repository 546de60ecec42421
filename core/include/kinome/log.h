#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

enum class LogLevel { kQuiet, kWarn, kInfo, kDebug };

/// Log lines go to stderr, through spdlog. Thread-safe.
KINOME_EXPORT void set_log_level(LogLevel level);
KINOME_EXPORT LogLevel log_level();
KINOME_EXPORT void log_warn(const std::string& message);
KINOME_EXPORT void log_info(const std::string& message);
KINOME_EXPORT void log_debug(const std::string& message);

}  // namespace kinome

#pragma once

#include <chrono>

#include "options/options.h"

namespace kinome::app {

/// Each command returns the program's exit status, and throws Error for errors of the user.
int render_command(const Options& options, std::chrono::steady_clock::time_point start);
int film_command(const Options& options, std::chrono::steady_clock::time_point start);
int relight_command(const Options& options, std::chrono::steady_clock::time_point start);
int merge_command(const Options& options, std::chrono::steady_clock::time_point start);
int check_command(const Options& options);
int plugins_command(const Options& options);
int check_plugin_command(const Options& options);
int new_plugin_command(const Options& options);

}  // namespace kinome::app

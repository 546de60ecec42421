#pragma once

#include <string>

namespace kinome::app {

/// Installs handlers for crashes (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT). They print one line
/// with the plugin that crashed, or that called the crashing code, and the program's activity. They
/// also remove temporary files, and end the program by the same signal.
///
/// The plugin is found from the addresses on the call stack, which costs nothing while plugins run.
/// Does nothing in builds with sanitizers, whose reports say more.
void install_crash_handlers();

/// Sets the activity that a crash report prints, such as "rendering". The string must live as long
/// as the program.
void set_activity(const char* activity);

/// Starts to record the call stacks of throws.
void watch_throws();
/// Returns "category/name" of the innermost plugin on the call stack when the exception object at
/// this address was thrown. Returns "" if there was no plugin, or if the throw is too long ago.
/// nullptr stands for the last exception.
std::string plugin_that_threw(const void* exception);

}  // namespace kinome::app

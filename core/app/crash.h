#pragma once

namespace kinome::app {

/// From here on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) is told in one line, with the
/// plugin whose code it was in, or that called it, and with what the program was doing; temporary
/// files are removed. The program then ends by the same signal as it would have without.
///
/// The plugin is found by the addresses of the call stack, so that plugins and those who call them
/// have nothing to note while they run. Not in builds for sanitizers, which say more themselves.
void tell_of_crashes();

/// What the program is doing from here on: "rendering". Lives as long as the program.
void set_activity(const char* activity);

}  // namespace kinome::app

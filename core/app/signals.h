#pragma once

#include <atomic>

namespace kinome::app {

/// SIGINT, SIGTERM and SIGHUP: while a render runs the first one asks it to end early; at any other
/// time, and the second time, the program ends at once and leaves no partial file. A signal that
/// was ignored from the start stays ignored.
void install_signal_handlers(bool quiet);

/// From here on there is something worth writing: the first signal sets cancel_flag(). `of_group`:
/// one of several processes, which give up what they are at.
void begin_interruptible_render(bool of_group = false);
const std::atomic<bool>& cancel_flag();
/// 128 + the signal that arrived, or 0.
int signal_exit_status();

}  // namespace kinome::app

#pragma once

#include <atomic>

namespace kinome::app {

/// Handles SIGINT, SIGTERM and SIGHUP. The first signal during a render cancels it. Any other one
/// ends the program at once, without leaving partial files. Signals that were ignored at the start
/// stay ignored.
void install_signal_handlers(bool quiet);

/// Makes the first signal from now on set cancel_flag() instead of ending the program. `of_group`
/// selects the message for a group of processes.
void begin_interruptible_render(bool of_group = false);
const std::atomic<bool>& cancel_flag();
/// Returns 128 + the signal that arrived, or 0.
int signal_exit_status();

}  // namespace kinome::app

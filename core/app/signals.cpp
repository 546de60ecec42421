#include "signals.h"

#include <cerrno>
#include <csignal>
#include <string_view>

#include <unistd.h>

#include "kinome/image.h"

namespace kinome::app {
namespace {

// Ctrl-C, a polite kill, a terminal that is closed (where nohup hasn't set that to be ignored).
constexpr int kInterrupts[] = {SIGINT, SIGTERM, SIGHUP};

// What a handler may touch: lock-free atomics.
std::atomic<bool> cancelled{false};
std::atomic<bool> rendering{false};
std::atomic<bool> silent{false};
std::atomic<bool> in_group{false};
std::atomic<int> received{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

extern "C" void handle_signal(int signal) {
  const int earlier = received.exchange(signal);
  if (earlier != 0 || !rendering) {
    remove_temporary_files();
    _exit(128 + signal);
  }
  cancelled = true;
  if (!silent) {
    constexpr std::string_view kAlone =
        "\ninterrupted: finishing the tiles at hand (once more to stop at once)\n";
    constexpr std::string_view kInGroup =
        "\ninterrupted: writing what there is, if the launcher leaves the time for it\n";
    const std::string_view note = in_group ? kInGroup : kAlone;
    // write() fails on a terminal that is closed; what the signal came between must not see that.
    const int error = errno;
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, note.data(), note.size());
    errno = error;
  }
}

}  // namespace

void install_signal_handlers(bool quiet) {
  silent = quiet;
  for (const int signal : kInterrupts) {
    struct sigaction current {};
    sigaction(signal, nullptr, &current);
    if (current.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = handle_signal;
    sigemptyset(&action.sa_mask);
    for (const int other : kInterrupts) sigaddset(&action.sa_mask, other);
    action.sa_flags = SA_RESTART;
    sigaction(signal, &action, nullptr);
  }
  // A file that outgrows its limit is a failed write, to be reported as any other.
  std::signal(SIGXFSZ, SIG_IGN);
}

void begin_interruptible_render(bool of_group) {
  in_group = of_group;
  rendering = true;
}
const std::atomic<bool>& cancel_flag() {
  return cancelled;
}
int signal_exit_status() {
  return received == 0 ? 0 : 128 + received;
}

}  // namespace kinome::app

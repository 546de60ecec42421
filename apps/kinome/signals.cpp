#include "signals.h"

#include <cerrno>
#include <csignal>
#include <string_view>

#include <unistd.h>

#include "kinome/output_files.h"
#include "kinome/image.h"

namespace kinome::app {
namespace {

// Ctrl-C, kill, and a closed terminal (unless nohup ignores that).
constexpr int kInterrupts[] = {SIGINT, SIGTERM, SIGHUP};

// State that the handler uses; lock-free atomics are async-signal-safe.
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
        "\ninterrupted: finishing the current tiles (interrupt again to stop at once)\n";
    constexpr std::string_view kInGroup =
        "\ninterrupted: writing the incomplete image, if the launcher leaves enough time\n";
    const std::string_view note = in_group ? kInGroup : kAlone;
    // write() fails on a closed terminal; the interrupted code must keep its errno.
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
  // Exceeding the file size limit then makes write() fail, which is reported as usual.
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

// The program `kinome`: runs a command and returns its exit status.

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <new>
#include <string>
#include <system_error>
#include <thread>

#include "commands.h"
#include "crash.h"
#include "farm/group.h"
#include "kinome/error.h"
#include "kinome/read_files.h"
#include "options/options.h"

namespace {

using Clock = std::chrono::steady_clock;

/// Returns the time at which the program was started, before dynamic linking. That ran on this
/// thread alone, so that its time is the processor time used until now.
Clock::time_point program_start() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return Clock::now() - std::chrono::seconds(used.tv_sec) - std::chrono::nanoseconds(used.tv_nsec);
}

/// Exit status for errors.
int failure_status = 1;

/// Prints an error as one line, and returns the exit status.
int fail(std::string message) {
  // Under MPI, all processes have most errors. The lowest rank prints first, and its exit makes the
  // launcher end the others.
  if (const int rank = kinome::app::rank_by_launcher(); rank > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100 * std::min(rank, 10)));
  }
  for (char& c : message) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "kinome: %s\n", message.c_str());
  return failure_status;
}

/// Prints the first errors of a scene, one line each.
int fail(const kinome::Errors& errors) {
  constexpr size_t kMaxPrinted = 10;
  const size_t count = errors.all().size();
  for (size_t i = 0; i < std::min(count, kMaxPrinted); ++i) fail(errors.all()[i].what());
  if (count > kMaxPrinted) {
    fail("and " + std::to_string(count - kMaxPrinted) + " more: --check lists them all");
  }
  return failure_status;
}

/// Prints an unexpected error, with the plugin that threw it if there is one.
int fail_unexpectedly(const void* exception, const std::string& what) {
  const std::string plugin = kinome::app::plugin_that_threw(exception);
  return fail((plugin.empty() ? "unexpected error: " : "plugin '" + plugin + "' failed: ") + what);
}

/// Returns `status`, or that of an error if stdout can't be written, for instance on a full disk.
int end_with(int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  return fail(std::string("stdout can't be written: ") + std::strerror(errno ? errno : EIO));
}

int run(const kinome::app::Options& options, Clock::time_point start) {
  switch (options.command) {
    case kinome::app::Options::Command::kRender:
      return options.check ? kinome::app::check_command(options)
                           : kinome::app::render_command(options, start);
    case kinome::app::Options::Command::kFilm:
      return kinome::app::film_command(options, start);
    case kinome::app::Options::Command::kMerge:
      return kinome::app::merge_command(options, start);
    case kinome::app::Options::Command::kRelight:
      return kinome::app::relight_command(options, start);
    case kinome::app::Options::Command::kListPlugins:
      return kinome::app::plugins_command(options);
    case kinome::app::Options::Command::kCheckPlugin:
      return kinome::app::check_plugin_command(options);
    case kinome::app::Options::Command::kNewPlugin:
      return kinome::app::new_plugin_command(options);
  }
  return failure_status;
}

}  // namespace

int main(int argc, char** argv) {
  const Clock::time_point start = program_start();
  kinome::app::watch_throws();
  kinome::app::install_crash_handlers();
  kinome::protect_read_files();
  failure_status = kinome::app::failure_status_of(argc, argv);
  try {
    const auto options = kinome::app::parse_options(argc, argv);
    if (!options) return end_with(0);
    // Under a launcher, commands that don't render an image are run by rank 0 alone.
    const bool is_picture =
        options->command == kinome::app::Options::Command::kRender && !options->check;
    if (!is_picture && options->mpi != kinome::app::Options::Mpi::kOff) {
      const int rank = kinome::app::rank_by_launcher();
      if (rank > 0) return 0;
      if (rank == 0 && options->command == kinome::app::Options::Command::kFilm) {
        throw kinome::Error(
            "kinome film doesn't support MPI: start a process for each --range of frames");
      }
    }
    return end_with(run(*options, start));
  } catch (const kinome::Errors& errors) {
    return fail(errors);
  } catch (const kinome::Error& error) {
    return fail(error.what());
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) return end_with(1);  // thrown by fmt::print
    // Thrown if a thread can't be started.
    if (error.code() == std::errc::resource_unavailable_try_again) {
      return fail("out of memory or threads: use fewer threads with -t COUNT");
    }
    return fail_unexpectedly(dynamic_cast<const void*>(&error), error.what());
  } catch (const std::exception& error) {
    return fail_unexpectedly(dynamic_cast<const void*>(&error), error.what());
  } catch (...) {
    return fail_unexpectedly(nullptr, "an unknown exception was thrown");
  }
}

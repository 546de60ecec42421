// The program: what its options ask for, and the statuses that it ends with.

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
#include "group.h"
#include "kinome/error.h"
#include "kinome/read_files.h"
#include "options.h"
#include "throw_site.h"

namespace {

using Clock = std::chrono::steady_clock;

/// When the program was started: the dynamic linker has been at work before main, all of it on this
/// thread, so that the processor time until now is the time since then.
Clock::time_point program_start() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return Clock::now() - std::chrono::seconds(used.tv_sec) - std::chrono::nanoseconds(used.tv_nsec);
}

/// The exit status when something went wrong.
int failure_status = 1;

/// Whatever went wrong: one line, and that status.
int fail(std::string message) {
  // What several processes do alike is said by the first, whose end is that of the others.
  if (const int rank = kinome::app::rank_by_launcher(); rank > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100 * std::min(rank, 10)));
  }
  for (char& c : message) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "kinome: %s\n", message.c_str());
  return failure_status;
}

/// The first ten of a scene's mistakes, one line each.
int fail(const kinome::Errors& errors) {
  constexpr size_t kMost = 10;
  const size_t count = errors.all().size();
  for (size_t i = 0; i < std::min(count, kMost); ++i) fail(errors.all()[i].what());
  if (count > kMost) {
    fail("and " + std::to_string(count - kMost) + " more: --check lists them all");
  }
  return failure_status;
}

/// What no one has foreseen: most likely a plugin's doing.
int fail_unexpectedly(const void* exception, const std::string& what) {
  const std::string plugin = kinome::app::plugin_that_threw(exception);
  return fail((plugin.empty() ? "unexpected error: " : "plugin '" + plugin + "' failed: ") + what);
}

/// Ends a command whose output must be on stdout: a full disk is an error.
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
  kinome::app::tell_of_crashes();
  kinome::protect_read_files();
  failure_status = kinome::app::failure_status_of(argc, argv);
  try {
    const auto options = kinome::app::parse_options(argc, argv);
    if (!options) return end_with(0);
    // Under a launcher, what doesn't render one picture together is done once.
    const bool is_picture =
        options->command == kinome::app::Options::Command::kRender && !options->check;
    if (!is_picture && options->mpi != kinome::app::Options::Mpi::kOff) {
      const int rank = kinome::app::rank_by_launcher();
      if (rank > 0) return 0;
      if (rank == 0 && options->command == kinome::app::Options::Command::kFilm) {
        throw kinome::Error("a film is not rendered by MPI: its frames can be rendered by processes "
                            "of their own (--range)");
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
    // What the start of a thread throws: its stack takes memory.
    if (error.code() == std::errc::resource_unavailable_try_again) {
      return fail("out of memory, or of threads: -t COUNT takes fewer");
    }
    return fail_unexpectedly(dynamic_cast<const void*>(&error), error.what());
  } catch (const std::exception& error) {
    return fail_unexpectedly(dynamic_cast<const void*>(&error), error.what());
  } catch (...) {
    return fail_unexpectedly(nullptr, "something that is no std::exception was thrown");
  }
}

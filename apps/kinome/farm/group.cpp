#include "farm/group.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <sched.h>

#include <fmt/format.h>

#include "kinome/error.h"
#include "own_library.h"

namespace kinome::app {
namespace {

/// Returns the number in an environment variable; -1 if it isn't set.
int number(const char* name) {
  const char* const text = std::getenv(name);
  return text && *text ? std::atoi(text) : -1;
}

struct Launcher {
  const char* rank;
  const char* size;
};
/// Variables of Open MPI, of PMI (MPICH, Intel MPI, Slurm's pmi2), and of PMIx, where the number of
/// processes comes from Slurm.
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                   {"PMI_RANK", "PMI_SIZE"},
                                   {"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}};

using Join = ProcessGroup* (*)(const char* version);

/// Returns the set of processors that this process may run on, and their number. The sets of
/// processes that share processors are equal.
std::pair<std::string, unsigned> processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0) {
    return {"", std::max(1u, std::thread::hardware_concurrency())};
  }
  return {std::string(reinterpret_cast<const char*>(&set), sizeof set),
          static_cast<unsigned>(std::max(1, CPU_COUNT(&set)))};
}

unsigned share_of_processors(ProcessGroup& group) {
  const auto [own, count] = processors();
  const std::string key = group.machine() + '\0' + own;
  unsigned sharing = 0;
  for (const std::string& theirs : group.gather(key, "agreement")) sharing += theirs == key;
  return std::max(1u, count / std::max(1u, sharing));
}

/// Splits a text into one error per line.
std::vector<Error> lines_of(const std::string& text) {
  std::vector<Error> lines;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    lines.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

}  // namespace

int rank_by_launcher() {
  for (const Launcher& launcher : kLaunchers) {
    if (number(launcher.rank) >= 0 && number(launcher.size) > 1) return number(launcher.rank);
  }
  return -1;
}

std::unique_ptr<ProcessGroup> join_group(const Options& options) {
  const int rank = rank_by_launcher();
  if (options.mpi == Options::Mpi::kOff) return nullptr;
  if (options.mpi == Options::Mpi::kAuto && rank < 0) return nullptr;
  const auto fail = [](const std::string& why) { throw Error("--mpi: " + why); };
  // Found on the same path as the core's library. Never closed, because MPI can't be unloaded.
  void* const library = open_own_library("libkinome_mpi.so", RTLD_NOW | RTLD_GLOBAL);
  if (!library) {
    const std::string why = dlerror();
    fail(
        "can't load libkinome_mpi.so (install the package kinome-mpi, or build kinome with MPI): " +
        why);
  }
  const auto join = reinterpret_cast<Join>(dlsym(library, "kinome_join_mpi_group"));
  std::unique_ptr<ProcessGroup> group(join ? join(KINOME_VERSION) : nullptr);
  if (!group) fail("libkinome_mpi.so is from another version of kinome");
  if (rank >= 0 && group->size() == 1) {
    group->finish();
    fail(
        "the launcher started several processes, but this program's MPI finds only one: they are "
        "of different MPI versions (--mpi off renders the whole image in each process)");
  }
  return group;
}

Options options_in(ProcessGroup& group, Options options) {
  // A collective operation: all processes must call it, even those that don't use the result.
  const unsigned share = share_of_processors(group);
  if (options.threads == 0) options.threads = share;
  if (group.is_root()) return options;
  options.quiet = true;
  options.stats = StatsFormat::kNone;
  options.display.clear();
  options.checkpoint.clear();
  options.png = false;
  return options;
}

void check_alike(ProcessGroup& group, const Checkpoint::Identity& identity) {
  const std::vector<std::string> machines = group.gather(group.machine(), "agreement");
  for (const auto& [name, own] : identity) {
    const std::vector<std::string> values = group.gather(own, "agreement");
    for (size_t rank = 1; rank < values.size(); ++rank) {
      if (values[rank] == values[0]) continue;
      if (name == Checkpoint::kScene) {
        throw AgreedError(
            fmt::format("rank {} on {} would render a different image: its scene differs "
                        "from that of rank 0 on {}, in the text of a file or in -D",
                        rank, machines[rank], machines[0]));
      }
      throw AgreedError(
          fmt::format("rank {} on {} would render a different image: its {} is '{}', "
                      "but that of rank 0 on {} is '{}'",
                      rank, machines[rank], name, values[rank], machines[0], values[0]));
    }
  }
}

int run_in_group(ProcessGroup& group, const std::function<int()>& fn) {
  // Limits the delay of ranks before they report an error.
  constexpr int kMaxDelays = 10;
  const auto fail = [&](const char* why) {
    // Most errors occur in all processes alike, and one message is enough: the lowest rank prints
    // it first and aborts the others.
    std::this_thread::sleep_for(
        std::chrono::milliseconds(100 * std::min(group.rank(), kMaxDelays)));
    std::fprintf(stderr, "kinome: rank %d on %s: %s\n", group.rank(), group.machine().c_str(), why);
    group.abort(1);
  };
  try {
    const int status = fn();
    group.finish();
    return group.is_root() ? status : 0;
  } catch (const AgreedError& error) {
    group.finish();
    // The root reports the error. A launcher would kill it if another process failed first.
    if (!group.is_root()) return 0;
    throw Errors(lines_of(error.lines()));
  } catch (const std::bad_alloc&) {
    fail("out of memory");
  } catch (const std::exception& error) {
    fail(error.what());
  } catch (...) {
    fail("an unknown exception was thrown");
  }
  return 1;
}

}  // namespace kinome::app

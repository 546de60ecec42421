#include "group.h"

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

namespace kinome::app {
namespace {

/// Number in the environment; -1: there is none.
int number(const char* name) {
  const char* const text = std::getenv(name);
  return text && *text ? std::atoi(text) : -1;
}

struct Launcher {
  const char* rank;
  const char* size;
};
/// Open MPI; what speaks PMI (MPICH, Intel MPI, Slurm's pmi2); what speaks PMIx, which leaves the
/// number of processes to Slurm.
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                   {"PMI_RANK", "PMI_SIZE"},
                                   {"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}};

using Join = ProcessGroup* (*)(const char* version);

/// Which processors this process may run on, as text: equal for those that share them.
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
  const std::string place = group.machine() + '\0' + own;
  unsigned sharing = 0;
  for (const std::string& theirs : group.gather(place, "agreement")) sharing += theirs == place;
  return std::max(1u, count / std::max(1u, sharing));
}

/// Names and values, each with an end of its own.
std::string text_of(const Checkpoint::Identity& identity) {
  std::string text;
  for (const auto& [name, value] : identity) text += name + '\0' + value + '\0';
  return text;
}

Checkpoint::Identity identity_of(const std::string& text) {
  Checkpoint::Identity identity;
  for (size_t begin = 0; begin < text.size();) {
    const std::string name = text.c_str() + begin;
    begin += name.size() + 1;
    const std::string value = text.c_str() + begin;
    begin += value.size() + 1;
    identity[name] = value;
  }
  return identity;
}

/// Each line a mistake of its own.
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
  // Found as the core's library is. Never closed: MPI would not stand it.
  void* const library = dlopen("libkinome_mpi.so", RTLD_NOW | RTLD_GLOBAL);
  if (!library) {
    const std::string why = dlerror();
    fail("this program is to render with others, but can't load what it needs for that (the package "
         "kinome-mpi, or a build where MPI was there): " +
         why);
  }
  const auto join = reinterpret_cast<Join>(dlsym(library, "kinome_join_mpi_group"));
  std::unique_ptr<ProcessGroup> group(join ? join(KINOME_VERSION) : nullptr);
  if (!group) fail("libkinome_mpi.so is of another version");
  if (rank >= 0 && group->size() == 1) {
    group->finish();
    fail("a launcher has started several processes, but to the MPI that this program was built with "
         "each is alone: it is another one's, or another version's (--mpi off renders each by "
         "itself)");
  }
  return group;
}

Options options_in(ProcessGroup& group, Options options) {
  // All ask, whether they need the answer or not.
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
  const std::vector<std::string> texts = group.gather(text_of(identity), "agreement");
  const std::vector<std::string> machines = group.gather(group.machine(), "agreement");
  const Checkpoint::Identity first = identity_of(texts[0]);
  for (size_t rank = 1; rank < texts.size(); ++rank) {
    for (const auto& [name, value] : identity_of(texts[rank])) {
      const auto found = first.find(name);
      const std::string other = found == first.end() ? "" : found->second;
      if (other == value) continue;
      if (name == Checkpoint::kScene) {
        throw AgreedError(fmt::format("rank {} on {} would render another picture: its scene is "
                                      "another one than that of rank 0 on {}, by the text of its "
                                      "files or by -D",
                                      rank, machines[rank], machines[0]));
      }
      throw AgreedError(fmt::format("rank {} on {} would render another picture: its {} is '{}', "
                                    "and that of rank 0 on {} is '{}'",
                                    rank, machines[rank], name, value, machines[0], other));
    }
  }
}

int run_in_group(ProcessGroup& group, const std::function<int()>& fn) {
  // No one waits longer for one that can't go on.
  constexpr int kMostTurns = 10;
  const auto fail = [&](const char* why) {
    // What all do alike they fail at alike, and one line is enough: the first that gets there ends
    // the others.
    std::this_thread::sleep_for(std::chrono::milliseconds(100 * std::min(group.rank(), kMostTurns)));
    std::fprintf(stderr, "kinome: rank %d on %s: %s\n", group.rank(), group.machine().c_str(), why);
    group.abort(1);
  };
  try {
    const int status = fn();
    group.finish();
    return group.is_root() ? status : 0;
  } catch (const AgreedError& error) {
    group.finish();
    // The root has yet to say what: a launcher kills it as soon as another one fails.
    if (!group.is_root()) return 0;
    throw Errors(lines_of(error.lines()));
  } catch (const std::bad_alloc&) {
    fail("out of memory");
  } catch (const std::exception& error) {
    fail(error.what());
  } catch (...) {
    fail("something that is no std::exception was thrown");
  }
  return 1;
}

}  // namespace kinome::app

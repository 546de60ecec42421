#pragma once

#include <functional>
#include <memory>

#include "kinome/checkpoint.h"
#include "kinome/process_group.h"
#include "options/options.h"

/// Rendering as one of several processes that an MPI launcher (mpirun, srun) has started.
namespace kinome::app {

/// Returns the rank of this process, from the launcher's environment variables; -1 without a
/// launcher, or if it started only one process.
int rank_by_launcher();

/// Joins the group of processes that render one image, as --mpi requests; returns nullptr if this
/// process is alone. MPI's library is loaded only for a group. Throws Error if a group is required
/// but can't be joined.
std::unique_ptr<ProcessGroup> join_group(const Options& options);
/// Returns the options of this process. Processes other than the root neither write files nor
/// print. The default number of threads is this process's share of the processors assigned by the
/// launcher.
Options options_in(ProcessGroup& group, Options options);
/// Throws an AgreedError that names a process and the value by which it differs, unless all
/// processes have the same identity. Collective; all identities must have the same names.
void check_alike(ProcessGroup& group, const Checkpoint::Identity& identity);

/// Returns the result of fn() on the root, and 0 on others, so that the job's status is the root's.
/// An AgreedError is rethrown on the root alone. After any other exception the process prints it
/// and aborts the group.
int run_in_group(ProcessGroup& group, const std::function<int()>& fn);

}  // namespace kinome::app

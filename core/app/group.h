#pragma once

#include <functional>
#include <memory>

#include "kinome/checkpoint.h"
#include "kinome/process_group.h"
#include "options.h"

/// This program as one of several processes that a launcher of MPI has started (mpirun, srun).
namespace kinome::app {

/// By what the launcher has left in the environment; -1: there is none, or it started no other.
int rank_by_launcher();

/// The group that renders together, by --mpi; nullptr: this process is alone. MPI is loaded only
/// where there is one. Throws Error where there should be one and MPI can't be had.
std::unique_ptr<ProcessGroup> join_group(const Options& options);
/// What is left to this process of what was asked for: all but the root write and say nothing.
/// Threads, where they were not asked for: this process's share of the processors that the launcher
/// has given it.
Options options_in(ProcessGroup& group, Options options);
/// Throws an AgreedError that says which process differs by what, unless all are about to render
/// the same.
void check_alike(ProcessGroup& group, const Checkpoint::Identity& identity);

/// What fn() returns on the root; 0 on others, so that the job's status is the root's. Of what all
/// have agreed that goes wrong the root alone throws an exception; where anything else does, one
/// process says so and ends all.
int run_in_group(ProcessGroup& group, const std::function<int()>& fn);

}  // namespace kinome::app

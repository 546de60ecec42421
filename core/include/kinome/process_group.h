#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/error.h"
#include "kinome/export.h"
#include "kinome/stats.h"

namespace kinome {

/// Error that all processes of a group throw together, with the same text, so that none waits for
/// the others.
class KINOME_EXPORT AgreedError : public Error {
 public:
  /// Takes one line per error.
  explicit AgreedError(const std::string& lines) : Error(lines), lines_(lines) {}
  const std::string& lines() const { return lines_; }

 private:
  std::string lines_;
};

/// Processes that render one image together, on one or more machines, started by a cluster's
/// launcher. All run the same program on the same scene, and make the same collective calls in the
/// same order. Each process has a rank, counted from 0; the root, rank 0, owns the film.
///
/// During a pass, the processes share work: each takes item numbers from a common counter and sends
/// its results to the root.
///
/// next(), stop() and send() are thread-safe. All other functions must be called by the rendering
/// thread.
class KINOME_EXPORT ProcessGroup {
 public:
  virtual ~ProcessGroup() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool is_root() const { return rank() == 0; }
  /// Name of the machine that this process runs on.
  virtual std::string machine() const = 0;

  /// Collective: returns `own` of all processes, by rank. `what` is the key for traffic().
  virtual std::vector<std::string> gather(std::string_view own, const char* what) = 0;
  /// Collective: returns the root's `bytes`; those of other processes are ignored.
  virtual std::string broadcast(std::string_view bytes, const char* what) = 0;

  using Receive = std::function<void(int rank, std::string_view bytes)>;
  /// Collective: begins a pass. On the root, `receive` is called with the data that others send
  /// until end_pass(), on the group's own threads, one at a time.
  virtual void begin_pass(Receive receive) = 0;
  /// Returns the next item number of the pass that no process has taken, from 0. After stop(),
  /// returns a number beyond all items.
  virtual uint64_t next() = 0;
  /// Makes next() return no more items, on all processes.
  virtual void stop() = 0;
  /// Sends data to the root, from any other process.
  virtual void send(std::string bytes) = 0;
  /// Collective: ends a pass. When it returns on the root, all data sent in the pass has been
  /// received. Returns `own` of all processes, as gather() does. The root rethrows exceptions of
  /// `receive`.
  virtual std::vector<std::string> end_pass(std::string_view own) = 0;

  /// Traffic of this process.
  virtual std::map<std::string, GroupTraffic> traffic() const = 0;
  /// Collective: called once when no common work is left.
  virtual void finish() = 0;
  /// Terminates all processes immediately, if this one can't continue and others would wait for it.
  [[noreturn]] virtual void abort(int status) = 0;
};

/// Calls fn() on all processes of a group; fn() must not communicate with the group. If any process
/// throws, all throw an AgreedError with the message of the lowest rank that failed. Without a
/// group (nullptr), just calls fn().
KINOME_EXPORT void on_all_processes(ProcessGroup* group, const std::function<void()>& fn);

/// True on the process that owns the film. Always true without a group (nullptr).
KINOME_EXPORT bool is_root(const ProcessGroup* group);
/// Returns the root's `value`, so that all processes use the same one, for example of the time.
/// Collective. Returns `value` without a group (nullptr).
KINOME_EXPORT double agree(ProcessGroup* group, double value);
/// Sums each value over all processes of the group (all-reduce). Collective. Does nothing without a
/// group (nullptr).
KINOME_EXPORT void sum_over_processes(ProcessGroup* group, std::span<uint64_t> numbers);

}  // namespace kinome

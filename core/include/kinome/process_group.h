#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/error.h"
#include "kinome/export.h"
#include "kinome/stats.h"

namespace kinome {

/// What all processes of a group throw together, with the same text: none of them waits for others.
class KINOME_EXPORT AgreedError : public Error {
 public:
  /// Of several mistakes each is a line.
  explicit AgreedError(const std::string& lines) : Error(lines), lines_(lines) {}
  const std::string& lines() const { return lines_; }

 private:
  std::string lines_;
};

/// Processes that render one picture together, on one machine or many, as the launcher of a cluster
/// has started them. All run the same program on the same scene, and come to the same collective
/// calls in the same order; each has a rank, from 0. The root, of rank 0, has the film.
///
/// A pass is the time in which they share work: each takes the numbers of items from one counter,
/// and sends what it makes to the root.
///
/// next(), stop() and send() may be called by any thread; all else by the one that renders.
class KINOME_EXPORT ProcessGroup {
 public:
  virtual ~ProcessGroup() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool is_root() const { return rank() == 0; }
  /// Name of this process's machine.
  virtual std::string machine() const = 0;

  /// Collective: what each process has to say, by rank. `what` it is about is for traffic().
  virtual std::vector<std::string> gather(std::string_view own, const char* what) = 0;
  /// Collective: what the root says. Others' `bytes` don't count.
  virtual std::string broadcast(std::string_view bytes, const char* what) = 0;

  using Receive = std::function<void(int rank, std::string_view bytes)>;
  /// Collective. On the root, `receive` is called with what others send until end_pass(), by one
  /// thread at a time, of the group's own.
  virtual void begin_pass(Receive receive) = 0;
  /// The next number of the pass that no process has taken yet, from 0; once one has called
  /// stop(), larger than any that is of use.
  virtual uint64_t next() = 0;
  virtual void stop() = 0;
  /// To the root, from any other.
  virtual void send(std::string bytes) = 0;
  /// Collective: once it returns on the root, all that was sent in the pass has been received. Says
  /// what gather() does. An exception of `receive` is thrown by the root.
  virtual std::vector<std::string> end_pass(std::string_view own) = 0;

  /// Of this process.
  virtual std::map<std::string, GroupTraffic> traffic() const = 0;
  /// Collective: nothing is left to do together.
  virtual void finish() = 0;
  /// Ends all processes, at once: where this one can't go on, and others would wait for it.
  [[noreturn]] virtual void abort(int status) = 0;
};

/// Has all processes of a group call fn(), which must ask nothing of the group; where any throws,
/// all throw an AgreedError, of what the first of them says. nullptr: fn() alone.
KINOME_EXPORT void together(ProcessGroup* group, const std::function<void()>& fn);

}  // namespace kinome

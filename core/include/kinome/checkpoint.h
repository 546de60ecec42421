#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

class Film;

/// What a render has finished, kept in a file from time to time, so that another run can go on from
/// there and come to the same bits, at any number of threads.
///
/// Kept are the film's sums and, for each pass (RenderContext::for_each), the items whose results
/// are in them (RenderContext::commit). A resumed render begins as any other and leaves these items
/// out. Passes that commit nothing, such as those that learn, are repeated: by the same seed they
/// find the same. What was decided by the film's contents (RenderContext::decide) is kept, too.
///
/// The file is written under a temporary name, synced and renamed: it is whole, or the one before.
/// It ends with a checksum, and says what it belongs to. In this machine's byte order.
///
/// Not thread-safe; the render context sees to that.
class KINOME_EXPORT Checkpoint {
 public:
  struct Options {
    std::string path;
    double every = 60;    ///< seconds from one write to the next
    bool resume = false;  ///< go on from the file, if there is one
    /// Called by begin() once the file is accepted.
    std::function<void()> on_resume = nullptr;
  };
  /// All that makes a picture what it is: names and values, such as "seed" and "7".
  using Identity = std::map<std::string, std::string>;
  /// The name by which an identity holds the scene's hash, which says nothing to people.
  static constexpr const char* kScene = "scene (by its text and -D)";

  /// Error where the file can't be written, is there though `resume` is false, or is damaged.
  explicit Checkpoint(Options options);

  const std::string& path() const { return options_.path; }
  /// Whether `path` leads to the same file, there or still to be written. Error where it can't be
  /// written.
  bool is_written_to(const std::string& path) const;
  /// There is a file to go on from.
  bool resumes() const { return resumes_; }

  /// What the render is: before begin().
  void set_identity(Identity identity) { identity_ = std::move(identity); }
  /// A render begins, with its film prepared: puts back what the file holds. Error where that
  /// belongs to another identity.
  void begin(Film& film);
  /// Another pass, of so many items.
  void begin_pass(size_t items);
  /// Whether an item of the pass is in the film already.
  bool is_done(size_t item) const;
  /// An item of the pass is in the film now, by so many commits. Writes the file if it is time to;
  /// a failure is a warning, and the render goes on.
  void add(Film& film, size_t item, uint64_t commits);
  /// What `decide` says, or said when the render that is being resumed came here.
  double decide(const std::function<double()>& decide);

  /// Writes the file, whether it is time to or not. As add().
  void save(Film& film) {
    if (!closed_) write(film);
  }
  /// Writes the file, and nothing after that. As add(), and only once.
  void close(Film& film);
  /// Nothing is written any more: the film holds what no pass accounts for.
  void abandon() { closed_ = true; }
  /// The picture is written: the file is of no use any more.
  void remove() const;

 private:
  struct Pass {
    uint64_t items = 0;
    uint64_t done_count = 0;
    std::vector<bool> done;  ///< empty where all or none are done
    bool has(size_t item) const { return done.empty() ? done_count > 0 : done[item]; }
  };
  void write(Film& film);
  void write_file(Film& film) const;
  void read_file(Film& film);

  using Clock = std::chrono::steady_clock;
  Options options_;
  Identity identity_;
  bool resumes_ = false;
  bool closed_ = false;
  Clock::time_point written_ = Clock::now();
  std::string last_failure_;  ///< to write; "": the last time it went well
  uint64_t commits_ = 0;  ///< that add() was told of
  std::vector<Pass> passes_;
  size_t next_pass_ = 0;
  std::vector<double> decisions_;
  size_t next_decision_ = 0;
};

}  // namespace kinome

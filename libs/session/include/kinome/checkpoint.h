#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "kinome/film.h"
#include "kinome/work_source.h"

namespace kinome {

/// File that records a render's progress from time to time, so that a later run can resume it. The
/// resumed render has the same bits, for any number of threads.
///
/// A checkpoint stores the film's sums and, for each pass (Scheduler::for_each()), the items
/// that are in them (Scheduler::commit()). A resumed render starts like any other and skips
/// these items. Passes without commits, such as learning passes, are repeated; they give the same
/// results for the same seed. Decisions that depend on the film's contents
/// (RenderJob::decide()) are stored, too.
///
/// The file is written under a temporary name, synced and renamed, so it is either complete or the
/// previous one. It contains the identity of the render and ends with a checksum. Its byte order is
/// that of the machine.
///
/// Not thread-safe; the scheduler serialises the calls.
class KINOME_EXPORT Checkpoint final : public WorkSource {
 public:
  struct Options {
    std::string path;
    double every = 60;    ///< seconds between writes
    bool resume = false;  ///< resume from the file if it exists
    /// Called by begin() once the file is accepted. May be empty.
    std::function<void()> on_resume = nullptr;
  };
  /// Everything that determines an image: names and values, such as "seed" and "7".
  using Identity = std::map<std::string, std::string>;
  /// Key of the scene's hash in an identity. Messages don't print its value.
  static constexpr const char* kScene = "scene (by its text and -D)";

  /// Throws Error if the file can't be written, exists although `resume` is false, or is damaged.
  explicit Checkpoint(Options options);

  const std::string& path() const { return options_.path; }
  /// True if `path` names the checkpoint's file, whether it exists yet or not. Throws Error if it
  /// can't be written.
  bool is_written_to(const std::string& path) const;
  /// True if there is a file to resume from.
  bool resumes() const override { return resumes_; }

  /// Sets the identity of the render. Call before begin().
  void set_identity(Identity identity) { identity_ = std::move(identity); }
  /// Begins a render whose film is prepared: restores the film from the file. Throws Error if the
  /// file belongs to another identity.
  void begin(Film& film) override;
  /// Begins a pass with this number of items.
  void begin_pass(size_t items) override;
  /// True if an item of the pass is in the film already.
  bool is_done(size_t item) const override;
  /// Records that an item of the pass is in the film, with this number of commits. Writes the file
  /// if it is due. A failed write is a warning; the render continues.
  void add(Film& film, size_t item, uint64_t commits) override;
  /// Returns decide(), or the stored result of the same decision in the resumed render.
  double decide(const std::function<double()>& decide) override;

  /// Writes the file now. Failures are handled as in add().
  void save(Film& film) override {
    if (!closed_) write(film);
  }
  /// Writes the file a last time. Failures are handled as in add(). Call it only once.
  void close(Film& film) override;
  /// Stops writing, because the film contains samples that no pass accounts for.
  void abandon() override { closed_ = true; }
  /// Deletes the file, once the image is written.
  void remove() const;

 private:
  struct Pass {
    uint64_t items = 0;
    uint64_t done_count = 0;
    std::vector<bool> done;  ///< empty if all or none are done
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
  std::string last_failure_;  ///< last failed write; "" if it succeeded
  uint64_t commits_ = 0;      ///< number of commits reported to add()
  std::vector<Pass> passes_;
  size_t next_pass_ = 0;
  std::vector<double> decisions_;
  size_t next_decision_ = 0;
};

}  // namespace kinome

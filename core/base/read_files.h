#pragma once

#include <set>
#include <string>

#include "kinome/read_files.h"

namespace kinome {

/// Set of files that one owner has read. They are registered during its lifetime.
class ReadFiles {
 public:
  ReadFiles();
  ~ReadFiles();
  ReadFiles(const ReadFiles&) = delete;
  ReadFiles& operator=(const ReadFiles&) = delete;

  /// Makes record_read_file() of this thread add to `files` during its lifetime. With nullptr, the
  /// files have no owner.
  class Recording {
   public:
    explicit Recording(ReadFiles& files) : Recording(&files) {}
    explicit Recording(ReadFiles* files);
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

   private:
    ReadFiles* const outer_;
  };
  /// Returns the owner to which record_read_file() of this thread adds, or nullptr.
  static ReadFiles* recorded_by_this_thread();

 private:
  friend void record_read_file(const std::string& path);
  friend bool is_read_file(const std::string& path);
  std::set<std::string> paths_;  ///< absolute
};

}  // namespace kinome

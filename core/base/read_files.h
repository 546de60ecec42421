#pragma once

#include <set>
#include <string>

#include "kinome/read_files.h"

namespace kinome {

/// The files that one owner has read; they are registered as long as it lives.
class ReadFiles {
 public:
  ReadFiles();
  ~ReadFiles();
  ReadFiles(const ReadFiles&) = delete;
  ReadFiles& operator=(const ReadFiles&) = delete;

  /// While it exists, note_read_file() in this thread adds to `files`.
  class Recording {
   public:
    explicit Recording(ReadFiles& files);
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

   private:
    ReadFiles* const outer_;
  };

 private:
  friend void note_read_file(const std::string& path);
  friend bool is_read_file(const std::string& path);
  std::set<std::string> paths_;  ///< absolute
};

}  // namespace kinome

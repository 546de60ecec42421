#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// New, empty folder for temporary files. The destructor removes it with its contents.
class KINOME_EXPORT ScratchFolder {
 public:
  /// Creates the folder next to `path`, on the same disk. Throws Error if that fails.
  explicit ScratchFolder(const std::string& path);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace kinome

#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// A new, empty folder for files that are needed for a moment. The destructor removes the folder
/// and all that is in it, and so never a file that existed before.
class KINOME_EXPORT ScratchFolder {
 public:
  /// Creates it in the folder of `path`, on the same disk. Throws Error if that fails.
  explicit ScratchFolder(const std::string& path);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace kinome

#pragma once

#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome {

/// Error for a file that is in none of the searched folders.
class MissingFile : public Error {
  using Error::Error;
};

/// Returns why an existing path can't be read as a file, such as "is a folder, not a file", or ""
/// if it can.
std::string unreadable(const std::string& path);

/// Returns the folder of a file; "." if the path has none.
std::string folder_of(const std::string& file);

/// Folder name for the working directory, which is searched last. A file found there is loaded with
/// a warning, because the scene depends on the directory it is rendered from.
inline const std::string kWorkingDirectory = "";

/// Returns the path of `name` in the first of `folders` that contains it (an absolute name is used
/// as it is), and registers the file with record_read_file(). Throws MissingFile, with the searched
/// folders, if there is none, and Error if the path is unreadable(). Errors are at `where`, and
/// `prefix` precedes their messages.
std::string find_file(const std::string& name, const std::vector<std::string>& folders,
                      const Location& where, const std::string& prefix = "");

}  // namespace kinome

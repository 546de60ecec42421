#pragma once

#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome {

/// Of a file that no search path holds.
class MissingFile : public Error {
  using Error::Error;
};

/// Why something that exists can't be read as a file: "is a folder, not a file"; "": it can.
std::string unreadable(const std::string& path);

/// The folder to search last, the working directory: a file found there is loaded with a warning,
/// because the scene shows something else when it is rendered from another directory.
inline const std::string kWorkingDirectory = "";

/// Returns the path of `name` in the first of `folders` that has it (an absolute name stands for
/// itself), and registers the file by note_read_file(). Throws MissingFile with the folders that
/// were searched, and Error if it finds a folder in place of a file: at `where`, with `prefix`
/// before the message.
std::string find_file(const std::string& name, const std::vector<std::string>& folders,
                      const Location& where, const std::string& prefix = "");

}  // namespace kinome

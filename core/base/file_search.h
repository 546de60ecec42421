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

/// The first of `folders` that holds `name` (an absolute name stands for itself). Throws
/// MissingFile that says where it looked, and Error where it finds a folder in place of a file: at
/// `where`, with `prefix` before the message.
std::string find_file(const std::string& name, const std::vector<std::string>& folders,
                      const Location& where, const std::string& prefix = "");

}  // namespace kinome

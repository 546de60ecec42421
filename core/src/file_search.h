#pragma once

#include <string>
#include <vector>

namespace kinome {

/// Why something that exists can't be read as a file: "is a folder, not a file"; "": it can.
std::string unreadable(const std::string& path);

/// The first of `folders` that holds `name` (an absolute name stands for itself). Throws Error
/// (without a place) that says where it looked, also where it finds a folder in place of a file.
std::string find_file(const std::string& name, const std::vector<std::string>& folders);

}  // namespace kinome

#include "file_search.h"

#include <filesystem>

#include "kinome/error.h"

namespace kinome {

std::string find_file(const std::string& name, const std::vector<std::string>& folders) {
  namespace fs = std::filesystem;
  if (name.empty()) throw Error("a file name is empty");
  std::vector<std::string> candidates{name};
  std::string looked_in;
  if (fs::path(name).is_relative() && !folders.empty()) {
    candidates.clear();
    for (const std::string& folder : folders) {
      candidates.push_back(folder == "." ? name : (fs::path(folder) / name).string());
      looked_in += (looked_in.empty() ? "; looked in " : ", ") + folder;
    }
  }
  for (const std::string& candidate : candidates) {
    std::error_code failed;
    if (fs::is_directory(candidate, failed)) throw Error("'" + candidate + "' is a folder");
    if (!fs::exists(candidate, failed)) continue;
    // A pipe or a device may have no end.
    if (!fs::is_regular_file(candidate, failed)) {
      throw Error("'" + candidate + "' is not a regular file");
    }
    return candidate;
  }
  throw Error("there is no file '" + name + "'" + looked_in);
}

}  // namespace kinome

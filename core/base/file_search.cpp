#include "base/file_search.h"

#include <filesystem>

#include "kinome/log.h"
#include "kinome/read_files.h"

namespace kinome {

namespace fs = std::filesystem;

std::string folder_of(const std::string& file) {
  const std::string folder = fs::path(file).parent_path().string();
  return folder.empty() ? "." : folder;
}

std::string unreadable(const std::string& path) {
  std::error_code failed;
  if (fs::is_directory(path, failed)) return "is a folder, not a file";
  // A pipe or a device may have no end, or block forever.
  if (!fs::is_regular_file(path, failed)) return "is not a regular file";
  // Files in /proc and /sys count as regular, but report a wrong size; some have no end or block.
  // canonical() returns "" if it fails, as for /proc/self/fd/N of a deleted file. Opening the file
  // then gives a better error than this function could.
  const std::string resolved = fs::canonical(path, failed).string();
  if (resolved.starts_with("/proc/") || resolved.starts_with("/sys/")) {
    return "is a virtual file of the kernel, not a file on a disk";
  }
  return "";
}

std::string find_file(const std::string& name, const std::vector<std::string>& folders,
                      const Location& where, const std::string& prefix) {
  if (name.empty()) throw Error(where, prefix + "a file name is empty");
  const bool is_searched = fs::path(name).is_relative() && !folders.empty();
  std::string looked_in;
  for (const std::string& folder : is_searched ? folders : std::vector<std::string>{"."}) {
    const bool is_working_directory = folder == kWorkingDirectory;
    const std::string candidate = folder == "." ? name : (fs::path(folder) / name).string();
    if (is_searched) {
      looked_in += (looked_in.empty() ? "; looked in " : ", ") +
                   (is_working_directory ? "the working directory" : folder);
    }
    std::error_code failed;
    if (!fs::exists(candidate, failed)) continue;
    if (const std::string why = unreadable(candidate); !why.empty()) {
      throw Error(where, prefix + "'" + candidate + "' " + why);
    }
    if (is_working_directory && !is_read_file(candidate)) {
      log_warn(Error(where, "'" + name + "' was found only in the working directory, so the " +
                                "scene can't be rendered from another one: move the file next to " +
                                "the scene, or add its folder with -a")
                   .what());
    }
    record_read_file(candidate);
    return candidate;
  }
  throw MissingFile(where, prefix + "there is no file '" + name + "'" + looked_in);
}

}  // namespace kinome

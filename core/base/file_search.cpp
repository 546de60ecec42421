#include "base/file_search.h"

#include <filesystem>

#include "kinome/log.h"
#include "kinome/read_files.h"

namespace kinome {

std::string unreadable(const std::string& path) {
  std::error_code failed;
  if (std::filesystem::is_directory(path, failed)) return "is a folder, not a file";
  // A pipe or a device may have no end, or block for ever.
  if (!std::filesystem::is_regular_file(path, failed)) return "is not a regular file";
  // The kernel's own count as regular. Some have no end, some block, all have another size than
  // they say.
  // Where a path can't be resolved, it is empty: of files that are open, but deleted, it is what
  // /proc says, and what is said of them when they are opened tells more.
  const std::string whole = std::filesystem::canonical(path, failed).string();
  if (whole.starts_with("/proc/") || whole.starts_with("/sys/")) {
    return "is no file on a disk, but made by the kernel as it is read";
  }
  return "";
}

std::string find_file(const std::string& name, const std::vector<std::string>& folders,
                      const Location& where, const std::string& prefix) {
  namespace fs = std::filesystem;
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
      log_warn(Error(where, "'" + name + "' was found only in the working directory, so that the " +
                                "scene can't be rendered from another one: move the file beside " +
                                "the scene, or name its folder by -a")
                   .what());
    }
    note_read_file(candidate);
    return candidate;
  }
  throw MissingFile(where, prefix + "there is no file '" + name + "'" + looked_in);
}

}  // namespace kinome

#include "session/scratch_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "output_files/file_writer.h"

namespace kinome {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& path) {
  const fs::path folder = fs::path(resolve_target(path)).parent_path();
  path_ = ((folder.empty() ? fs::path(".") : folder) / ".kinome-XXXXXX").string();
  if (!::mkdtemp(path_.data())) {
    throw Error(fmt::format("cannot create a temporary folder in '{}': {}",
                            fs::path(path_).parent_path().string(), std::strerror(errno)));
  }
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace kinome

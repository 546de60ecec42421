#include "own_library.h"

#include <dlfcn.h>

#include <filesystem>

#include "kinome/stats.h"

namespace kinome::app {

void* open_own_library(const char* name, int mode) {
  Dl_info core{};
  if (dladdr(reinterpret_cast<const void*>(&peak_memory_bytes), &core) && core.dli_fname) {
    const auto path = std::filesystem::path(core.dli_fname).replace_filename(name);
    std::error_code failed;
    if (std::filesystem::exists(path, failed)) return dlopen(path.c_str(), mode);
  }
  return dlopen(name, mode);
}

}  // namespace kinome::app

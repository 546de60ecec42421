#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/plugin_registry.h"
#include "kinome/scene_loader.h"

/// What each target defines: one input, whatever bytes they are. An Error is as good as success;
/// any other exception, a crash or a report of the sanitizers is a finding.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace kinome::fuzz {

/// Of this build, without a word on stderr.
inline PluginRegistry& registry() {
  set_log_level(LogLevel::kQuiet);
  static PluginRegistry instance({KINOME_FUZZ_PLUGINS});
  return instance;
}

/// The input as a file of its own, in TMPDIR.
class InputFile {
 public:
  explicit InputFile(const std::string& extension)
      : path_((std::filesystem::temp_directory_path() /
               ("kinome-fuzz-" + std::to_string(getpid()) + extension))
                  .string()) {}
  ~InputFile() { ::unlink(path_.c_str()); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& write(const void* data, size_t size) const {
    std::ofstream(path_, std::ios::binary)
        .write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    return path_;
  }

 private:
  std::string path_;
};

/// The object of `<TAG type="TYPE">` with that file, or nullptr where it is an Error.
inline std::shared_ptr<Object> load_file(const std::string& tag, const std::string& type,
                                         const std::string& path) {
  try {
    return load_object_from_string("<" + tag + " type=\"" + type +
                                       "\"><string name=\"filename\" value=\"" + path + "\"/></" +
                                       tag + ">",
                                   "fuzz.xml", {}, registry());
  } catch (const Error&) {
    return nullptr;
  }
}

}  // namespace kinome::fuzz

#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/plugin_registry.h"
#include "kinome/properties.h"
#include "kinome/scene_loader.h"

/// What each target defines: one input, whatever bytes they are. An Error is as good as success
/// (it is left in `refusal`); any other exception, a crash or a report of the sanitizers is a
/// finding.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace kinome::fuzz {

/// The Error that the input was refused with; empty: it was accepted. libFuzzer needs none of it,
/// but the replay must know whether any seed still gets past the door.
inline std::string refusal;

/// Of this build, without a word on stderr.
inline PluginRegistry& registry() {
  set_log_level(LogLevel::kQuiet);
  static PluginRegistry instance({KINOME_FUZZ_PLUGINS});
  return instance;
}

/// The input as a file of its own, in TMPDIR. It stays open: there are millions of inputs.
class InputFile {
 public:
  explicit InputFile(const std::string& extension)
      : path_((std::filesystem::temp_directory_path() /
               ("kinome-fuzz-" + std::to_string(getpid()) + extension))
                  .string()),
        file_(::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)) {}
  ~InputFile() {
    ::close(file_);
    ::unlink(path_.c_str());
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& write(const void* data, size_t size) const {
    if (::pwrite(file_, data, size, 0) != static_cast<ssize_t>(size) ||
        ::ftruncate(file_, static_cast<off_t>(size)) != 0) {
      throw std::runtime_error("'" + path_ + "' can't be written");
    }
    return path_;
  }

 private:
  std::string path_;
  int file_;
};

/// The plugin's object with that file, or nullptr where it is an Error. Made without XML, which
/// has a target of its own and would take most of the time here.
inline std::shared_ptr<Object> load_file(Category category, const std::string& type,
                                         const std::string& path) {
  const Location where{"fuzz.xml", 1, 1};
  try {
    Properties props(category, type, where);
    props.set("filename", path, where);
    return registry().create(props);
  } catch (const Error& error) {
    refusal = error.what();
    return nullptr;
  }
}

}  // namespace kinome::fuzz

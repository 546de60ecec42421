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

/// Function that each target defines: reads one input of arbitrary bytes. An Error is a success
/// (its message is in `refusal`). Any other exception, a crash or a sanitizer report is a finding.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace kinome::fuzz {

/// Message of the Error that refused the input; empty if it was accepted. libFuzzer ignores it. The
/// replay uses it to test that some seeds are still accepted.
inline std::string refusal;

/// Returns the plugins of this build, and turns messages off.
inline PluginRegistry& registry() {
  set_log_level(LogLevel::kQuiet);
  static PluginRegistry instance({KINOME_FUZZ_PLUGINS});
  return instance;
}

/// The input as a file in TMPDIR. The file stays open, because there are millions of inputs.
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

/// Returns the plugin's object with that file, or nullptr after an Error. It doesn't use XML, which
/// has its own target and would take most of the time here.
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

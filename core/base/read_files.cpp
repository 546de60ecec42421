#include "base/read_files.h"

#include <atomic>
#include <filesystem>
#include <mutex>

namespace kinome {
namespace {

namespace fs = std::filesystem;

/// All existing owners, and the mutex that protects their paths. Never destroyed, because owners
/// may outlive static objects.
struct Registry {
  std::mutex mutex;
  std::set<const ReadFiles*> owners;
};
Registry& registry() {
  static Registry* const all = new Registry;
  return *all;
}

/// Files that were read without an owner; nullptr before protect_read_files().
std::atomic<ReadFiles*> files_of_process{nullptr};

thread_local ReadFiles* recording = nullptr;

}  // namespace

ReadFiles::ReadFiles() {
  const std::lock_guard lock(registry().mutex);
  registry().owners.insert(this);
}

ReadFiles::~ReadFiles() {
  const std::lock_guard lock(registry().mutex);
  registry().owners.erase(this);
}

ReadFiles::Recording::Recording(ReadFiles& files) : outer_(recording) {
  recording = &files;
}

ReadFiles::Recording::~Recording() {
  recording = outer_;
}

void protect_read_files() {
  static ReadFiles* const files = new ReadFiles;
  files_of_process = files;
}

void note_read_file(const std::string& path) {
  ReadFiles* const files = recording ? recording : files_of_process.load();
  if (!files) return;
  std::error_code failed;
  const fs::path absolute = fs::absolute(path, failed);  // the working directory may change
  const std::lock_guard lock(registry().mutex);
  files->paths_.insert(failed ? path : absolute.string());
}

bool is_read_file(const std::string& path) {
  std::error_code failed;
  if (!fs::exists(path, failed)) return false;
  // Compares files, not paths, because links give a file several names.
  const std::lock_guard lock(registry().mutex);
  for (const ReadFiles* const owner : registry().owners) {
    for (const std::string& read : owner->paths_) {
      if (fs::equivalent(path, read, failed)) return true;
    }
  }
  return false;
}

}  // namespace kinome

#include "base/read_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <new>

#include "kinome/error.h"

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

/// Returns an Error for the failed call that set errno.
Error unreadable_file(const std::string& path) {
  return Error(Location{path}, std::string("can't be read: ") + std::strerror(errno));
}

}  // namespace

ReadFiles::ReadFiles() {
  const std::lock_guard lock(registry().mutex);
  registry().owners.insert(this);
}

ReadFiles::~ReadFiles() {
  const std::lock_guard lock(registry().mutex);
  registry().owners.erase(this);
}

ReadFiles::Recording::Recording(ReadFiles* files) : outer_(recording) {
  recording = files;
}

ReadFiles::Recording::~Recording() {
  recording = outer_;
}

ReadFiles* ReadFiles::recorded_by_this_thread() {
  return recording;
}

std::string file_contents(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (!file) throw unreadable_file(path);
  // Files of unknown size (pipes) are read in steps.
  const bool seekable = std::fseek(file.get(), 0, SEEK_END) == 0;
  const long size = seekable ? std::ftell(file.get()) : -1;
  if (seekable) std::rewind(file.get());
  size_t filled = 0;
  // One byte more than the size, so that a single read reaches the end. Folders report a size of
  // LONG_MAX; reading them fails.
  constexpr size_t kStep = 1 << 20;
  std::string bytes;
  try {
    bytes.resize(size > 0 && size < (int64_t{1} << 40) ? static_cast<size_t>(size) + 1 : kStep);
    while (const size_t n =
               std::fread(bytes.data() + filled, 1, bytes.size() - filled, file.get())) {
      filled += n;
      if (filled == bytes.size()) bytes.resize(bytes.size() + kStep);
    }
  } catch (const std::bad_alloc&) {
    const auto read = static_cast<double>(std::max<int64_t>(size, static_cast<int64_t>(filled)));
    throw Error(Location{path}, fmt::format("doesn't fit in memory ({:.3g} GB)", 1e-9 * read));
  }
  if (std::ferror(file.get())) throw unreadable_file(path);
  bytes.resize(filled);
  return bytes;
}

void protect_read_files() {
  static ReadFiles* const files = new ReadFiles;
  files_of_process = files;
}

void record_read_file(const std::string& path) {
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

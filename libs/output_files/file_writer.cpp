#include "output_files/file_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <random>

#include "base/file_search.h"
#include "base/read_files.h"
#include "kinome/image.h"
#include "kinome/output_files.h"

namespace kinome {
namespace {

namespace fs = std::filesystem;

/// Path of a temporary file that exists now. A signal handler reads the slots, so there are no
/// allocations and no locks. A file without a slot is written all the same, but the signal handler
/// doesn't remove it.
struct Slot {
  enum State : int { kFree, kFilling, kUsed };
  std::atomic<int> state{kFree};
  char path[PATH_MAX];
};
constexpr int kSlotCount = 16;
std::array<Slot, kSlotCount> slots;
static_assert(std::atomic<int>::is_always_lock_free);

int acquire_slot(const std::string& path) {
  if (path.size() >= PATH_MAX) return -1;
  for (int i = 0; i < kSlotCount; ++i) {
    int expected = Slot::kFree;
    if (slots[i].state.compare_exchange_strong(expected, Slot::kFilling)) {
      std::memcpy(slots[i].path, path.c_str(), path.size() + 1);
      slots[i].state.store(Slot::kUsed, std::memory_order_release);
      return i;
    }
  }
  return -1;
}

void release_slot(int slot) {
  if (slot >= 0) slots[slot].state.store(Slot::kFree, std::memory_order_release);
}

Error write_error(const std::string& path, const std::string& why) {
  return Error(fmt::format("cannot write '{}': {}", path, why));
}

/// Returns the target of a chain of symbolic links, which needn't exist. fs::canonical() isn't used
/// because it must read all parent folders.
fs::path follow_links(const std::string& path) {
  constexpr int kMaxLinks = 40;  // the limit of Linux
  fs::path target = path;
  std::error_code failed;
  for (int i = 0; fs::is_symlink(fs::symlink_status(target, failed)); ++i) {
    if (i == kMaxLinks) throw write_error(path, std::strerror(ELOOP));
    const fs::path next = fs::read_symlink(target, failed);
    if (failed) throw write_error(path, failed.message());
    target = target.parent_path() / next;  // just `next` if it is absolute
  }
  return target;
}

std::string temporary_name(const std::string& target) {
  static std::atomic<unsigned> counter{0};
  static const unsigned random = std::random_device{}();
  const fs::path path(target);
  // The name doesn't contain the file's own name, because names have at most 255 bytes. The random
  // number is needed because process ids are reused, and other machines may share the folder.
  const std::string name =
      fmt::format(".kinome-{}-{}-{:08x}.tmp", ::getpid(), counter.fetch_add(1), random);
  return (path.parent_path() / name).string();
}

int open_file(const std::string& path, int flags) {
  int fd = -1;
  do {
    fd = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  } while (fd < 0 && errno == EINTR);
  return fd;
}

/// Returns the path by which an open, unnamed file can be linked to a name.
std::string descriptor_path(int fd) {
  return fmt::format("/proc/self/fd/{}", fd);
}

/// Creates an unnamed file in the folder. Returns its descriptor, or -1 if the file system doesn't
/// support unnamed files.
int create_unnamed(const std::string& folder) {
  const int fd = open_file(folder, O_TMPFILE | O_RDWR);
  std::error_code ignored;
  if (fd < 0 || fs::exists(descriptor_path(fd), ignored)) return fd;
  ::close(fd);
  return -1;
}

/// Writes the folder's entries to the disk. Returns 0 or an errno.
int sync_folder(const std::string& folder) {
  const int fd = open_file(folder, O_RDONLY | O_DIRECTORY);
  // A folder without read permission can't be synced. The file itself has been synced.
  if (fd < 0) return errno == EACCES ? 0 : errno;
  // File systems that can't sync folders return EINVAL.
  const int code = ::fsync(fd) == 0 || errno == EINVAL ? 0 : errno;
  ::close(fd);
  return code;
}

}  // namespace

std::string lower_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_null_device(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode) &&
         status.st_rdev == makedev(1, 3);
}

std::string resolve_target(const std::string& path) {
  if (path.empty()) throw Error("cannot write a file without a name");
  const fs::path target = follow_links(path);
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  if (fs::is_directory(status) || target.native().back() == '/') {
    throw write_error(path, "it names a folder, expected a file");
  }
  // Renaming onto a device or a pipe would replace it.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw write_error(path, "it exists and is not a regular file");
  }
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const fs::file_status of_folder = fs::status(folder, ignored);
  if (of_folder.type() == fs::file_type::none) {
    throw write_error(path, ignored.message());  // a loop of links, a name that is too long, ...
  }
  // If the type is unknown, opening the file reports why.
  if (of_folder.type() == fs::file_type::not_found) {
    throw write_error(path, fmt::format("the folder '{}' does not exist", folder.string()));
  }
  if (of_folder.type() != fs::file_type::unknown && !fs::is_directory(of_folder)) {
    throw write_error(path, fmt::format("'{}' is not a folder", folder.string()));
  }
  return target.string();
}

FileWriter::FileWriter(const std::string& path, ReadFile read_file)
    : path_(path), target_(resolve_target(path)) {
  if (read_file == ReadFile::kKeep && is_read_file(target_)) {
    throw write_error(path,
                      "this file was read by the scene or by the command and is never "
                      "overwritten: choose another name");
  }
  temporary_ = temporary_name(target_);
  slot_ = acquire_slot(temporary_);
  int fd = create_unnamed(folder_of(target_));
  if (fd < 0) {
    fd = open_file(temporary_, O_CREAT | O_EXCL | O_RDWR);
    is_named_ = fd >= 0;
  }
  if (fd >= 0) file_ = ::fdopen(fd, "w+b");
  if (!file_) {
    const int code = errno;
    if (fd >= 0) ::close(fd);
    if (is_named_) ::unlink(temporary_.c_str());
    release_slot(slot_);
    throw failure(code);
  }
}

FileWriter::~FileWriter() {
  if (file_) {
    std::fclose(file_);
    if (is_named_) ::unlink(temporary_.c_str());
  }
  release_slot(slot_);
}

void FileWriter::write(const void* bytes, size_t count) noexcept {
  if (errno_ == 0 && std::fwrite(bytes, 1, count, file_) != count) errno_ = errno ? errno : EIO;
  position_ += count;
}

void FileWriter::seek(uint64_t position) noexcept {
  if (errno_ == 0 && ::fseeko(file_, static_cast<off_t>(position), SEEK_SET) != 0) errno_ = errno;
  position_ = position;
}

void FileWriter::name_file() {
  const std::string from = descriptor_path(::fileno(file_));
  if (::linkat(AT_FDCWD, from.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0) {
    errno_ = errno;
    return;
  }
  is_named_ = true;
}

void FileWriter::check_name() {
  if (!is_named_) name_file();
  if (errno_ != 0) throw failure(errno_);
}

void FileWriter::commit(bool durable) {
  if (errno_ == 0 && std::fflush(file_) != 0) errno_ = errno;
  if (errno_ == 0 && durable && ::fsync(::fileno(file_)) != 0) errno_ = errno;
  if (errno_ == 0 && !is_named_) name_file();
  // Network file systems report a full disk only when the file is closed.
  if (std::fclose(file_) != 0 && errno_ == 0) errno_ = errno;
  file_ = nullptr;
  if (errno_ == 0 && std::rename(temporary_.c_str(), target_.c_str()) != 0) errno_ = errno;
  if (errno_ != 0) {
    if (is_named_) ::unlink(temporary_.c_str());
    throw failure(errno_);
  }
  if (durable) errno_ = sync_folder(folder_of(target_));
  if (errno_ != 0) throw failure(errno_);
}

Error FileWriter::failure(int code) const {
  return write_error(path_, std::strerror(code));
}

void sync_file(const std::string& path) {
  if (is_null_device(path)) return;
  const int fd = open_file(path, O_RDONLY);
  int code = fd < 0 || ::fsync(fd) != 0 ? errno : 0;
  if (fd >= 0) ::close(fd);
  if (code == 0) code = sync_folder(folder_of(path));
  if (code != 0) throw write_error(path, std::strerror(code));
}

bool are_written_to_one_file(const std::string& a, const std::string& b) {
  std::error_code failed;
  if (fs::equivalent(a, b, failed)) return true;
  if (is_null_device(a) || is_null_device(b)) return false;
  // The files may not exist yet; compare their folders and names.
  const fs::path target_a = resolve_target(a), target_b = resolve_target(b);
  return target_a.filename() == target_b.filename() &&
         fs::equivalent(folder_of(target_a), folder_of(target_b), failed);
}

void remove_temporary_files() noexcept {
  const int saved = errno;
  for (const Slot& slot : slots) {
    if (slot.state.load(std::memory_order_acquire) == Slot::kUsed) ::unlink(slot.path);
  }
  errno = saved;
}

void check_writable(const std::string& path) {
  if (is_null_device(path)) return;
  // Only creating a file detects read-only file systems and quotas. A full disk remains undetected,
  // because an empty file takes no space.
  FileWriter(path).check_name();
}

void write_text(const std::string& path, const std::string& text) {
  FileWriter file(path);
  file.write(text.data(), text.size());
  file.commit();
}

}  // namespace kinome

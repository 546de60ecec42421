#include "base/file_writer.h"

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

#include "base/read_files.h"
#include "kinome/image.h"

namespace kinome {
namespace {

namespace fs = std::filesystem;

/// Paths of the temporary files that exist now, where a signal handler can read them: no
/// allocation, no locks. A file that finds no free slot is written all the same, but not cleaned up
/// by a signal.
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

/// Where symbolic links lead to, whether there is a file or not: a link that leads to none names
/// the one that is to be. Not by canonical paths: those need to read all folders above.
fs::path follow_links(const std::string& path) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  fs::path target = path;
  std::error_code failed;
  for (int i = 0; fs::is_symlink(fs::symlink_status(target, failed)); ++i) {
    if (i == kMostLinks) throw write_error(path, std::strerror(ELOOP));
    const fs::path next = fs::read_symlink(target, failed);
    if (failed) throw write_error(path, failed.message());
    target = target.parent_path() / next;  // `next` alone, where that is absolute
  }
  return target;
}

std::string temporary_name(const std::string& target) {
  static std::atomic<unsigned> counter{0};
  static const unsigned random = std::random_device{}();
  const fs::path path(target);
  // Short whatever the file's own name is: names end at 255 bytes. Process numbers come again, and
  // folders may be shared with other machines.
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

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// By which an open file without a name can be given one.
std::string descriptor_path(int fd) {
  return fmt::format("/proc/self/fd/{}", fd);
}

/// A file of no name in the folder; negative where the file system knows no such thing.
int create_unnamed(const std::string& folder) {
  const int fd = open_file(folder, O_TMPFILE | O_RDWR);
  std::error_code ignored;
  if (fd < 0 || fs::exists(descriptor_path(fd), ignored)) return fd;
  ::close(fd);
  return -1;
}

/// 0, or the errno of what failed.
int sync_folder(const std::string& folder) {
  const int fd = open_file(folder, O_RDONLY | O_DIRECTORY);
  // A folder that may be written but not read can't be synced by us; the file itself is.
  if (fd < 0) return errno == EACCES ? 0 : errno;
  // Some file systems have nothing to sync here, and say so by this.
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
    throw write_error(path, ignored.message());  // a loop, a name too long, ...
  }
  // Where it is unknown, opening the file says why.
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
                      "this file was read, by the scene or by the command, and is never "
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
  // Of those that are still to be, the folders can be compared.
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
  // Creating a file and naming it is the one check that also sees read-only file systems and
  // quotas. A full disk it doesn't see: an empty file takes no room there.
  FileWriter(path).check_name();
}

void write_text(const std::string& path, const std::string& text) {
  FileWriter file(path);
  file.write(text.data(), text.size());
  file.commit();
}

}  // namespace kinome

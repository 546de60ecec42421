#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "kinome/error.h"
#include "kinome/export.h"

namespace kinome {

/// Writes a file atomically: the file gets its name only in commit(), so that `path` is either the
/// complete new file or unchanged. Until then it is unnamed, or has a temporary name if the file
/// system doesn't support unnamed files.
///
/// The first failure (a full disk, say) is stored, and commit() throws it. Without a commit nothing
/// is left behind. If the program is killed, only a file with a temporary name is left.
class FileWriter {
 public:
  /// What to do if `path` is a file that was read before (see kinome/read_files.h).
  enum class ReadFile { kKeep, kReplace };
  /// Throws Error if the file can't be created or must not be overwritten.
  explicit FileWriter(const std::string& path, ReadFile read_file = ReadFile::kKeep);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void write(const void* bytes, size_t count) noexcept;
  void seek(uint64_t position) noexcept;
  uint64_t position() const { return position_; }
  bool failed() const { return errno_ != 0; }
  /// Gives the file its temporary name now. Throws Error if that fails.
  void check_name();
  /// Renames the file to `path`. Throws Error if any write failed, and leaves `path` unchanged.
  /// `durable`: the file survives a crash of the machine once commit() has returned. The name does
  /// so only if the folder is readable. If syncing the folder fails, Error is thrown although
  /// `path` is the new file already.
  void commit(bool durable = false);

 private:
  /// Gives an unnamed file its temporary name.
  void name_file();
  Error failure(int code) const;
  std::string path_;    ///< as given by the caller, for messages
  std::string target_;  ///< with symbolic links followed
  std::string temporary_;
  std::FILE* file_ = nullptr;
  bool is_named_ = false;  ///< the file has the name temporary_
  int slot_ = -1;          ///< index of its slot, which remove_temporary_files() reads; -1: none
  uint64_t position_ = 0;
  int errno_ = 0;
};

/// Returns the file extension in lower case, with its dot.
KINOME_EXPORT std::string lower_extension(const std::string& path);
/// Returns true if `path` is /dev/null or a link to it.
KINOME_EXPORT bool is_null_device(const std::string& path);
/// Returns `path` with symbolic links followed. The file needn't exist. Throws Error if it can't be
/// written.
std::string resolve_target(const std::string& path);
/// Returns true if both paths name the same file, which needn't exist. Throws Error if it can't be
/// written.
KINOME_EXPORT bool are_written_to_one_file(const std::string& a, const std::string& b);

}  // namespace kinome

#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "kinome/error.h"
#include "kinome/export.h"

namespace kinome {

/// Writes a file that has no name yet, or a temporary one where the file system can't do without,
/// and gives it its name in commit(): the file is whole, or what it was before. The first failure
/// (a full disk) is remembered; commit() throws it. Without a commit nothing stays behind, even of
/// a program that is killed (but for a temporary name).
class FileWriter {
 public:
  /// Whether a file that was read (see kinome/read_files.h) may be overwritten.
  enum class ReadFile { kKeep, kReplace };
  /// Throws Error where the file can't be created, or is one that must be kept.
  explicit FileWriter(const std::string& path, ReadFile read_file = ReadFile::kKeep);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void write(const void* bytes, size_t count) noexcept;
  void seek(uint64_t position) noexcept;
  uint64_t position() const { return position_; }
  bool failed() const { return errno_ != 0; }
  /// Gives the file its temporary name now; throws Error where the folder refuses it.
  void check_name();
  /// Throws Error where any write failed, and leaves `path` as it was. `durable`: once it returns,
  /// the file is on the disk, whatever happens to the machine (its name only as far as the folder
  /// can be read). Where the disk fails at the last step, to keep the name, Error is thrown though
  /// `path` is the new file already.
  void commit(bool durable = false);

 private:
  /// Gives an unnamed file its temporary name.
  void name_file();
  Error failure(int code) const;
  std::string path_;    ///< as the caller gave it: for messages
  std::string target_;  ///< with symbolic links followed
  std::string temporary_;
  std::FILE* file_ = nullptr;
  bool is_named_ = false;  ///< by temporary_
  int slot_ = -1;          ///< in the list of remove_temporary_files()
  uint64_t position_ = 0;
  int errno_ = 0;
};

/// Returns the extension of a file's name in lower case, with its dot.
KINOME_EXPORT std::string lower_extension(const std::string& path);
/// Returns whether `path` is /dev/null, or a link to it.
KINOME_EXPORT bool is_null_device(const std::string& path);
/// The file that `path` names once symbolic links are followed, whether it is there or not; Error
/// where it can't be written.
std::string resolve_target(const std::string& path);
/// Whether these are names of one file, which may still be to be written. Error as above.
bool are_written_to_one_file(const std::string& a, const std::string& b);

}  // namespace kinome

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kinome::viewer {

/// An entry of a folder.
struct FileEntry {
  std::string name;
  bool is_folder = false;
  bool operator==(const FileEntry&) const = default;
};

/// Contents of a folder.
struct FileList {
  std::vector<FileEntry> entries;
  std::string fault;  ///< error message if the folder can't be read, otherwise ""
};

/// Returns the folders and the files with one of these extensions (".exr", in lower case; all files
/// if there are none). Folders come first; both are sorted by name, ignoring case. Hidden entries
/// are left out.
FileList list_files(const std::filesystem::path& folder,
                    const std::vector<std::string>& extensions);

/// Returns the entries whose names contain `text`, ignoring case.
std::vector<FileEntry> matching(const std::vector<FileEntry>& entries, const std::string& text);

/// Returns the path that a user means by `text` in a folder: "" is the folder itself, and "~" the
/// home folder. The result is normalised.
std::filesystem::path path_in(const std::filesystem::path& folder, const std::string& text);

/// Returns the path with the first of the extensions, unless it has one of them.
std::filesystem::path with_extension(std::filesystem::path path,
                                     const std::vector<std::string>& extensions);

}  // namespace kinome::viewer

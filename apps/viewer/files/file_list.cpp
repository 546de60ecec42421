#include "files/file_list.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <tuple>

namespace kinome::viewer {
namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool has_extension(const fs::path& path, const std::vector<std::string>& extensions) {
  const std::string extension = lower(path.extension().string());
  return extensions.empty() ||
         std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

}  // namespace

FileList list_files(const fs::path& folder, const std::vector<std::string>& extensions) {
  FileList list;
  std::error_code fault;
  fs::directory_iterator at(folder, fs::directory_options::skip_permission_denied, fault);
  for (const fs::directory_iterator end; !fault && at != end; at.increment(fault)) {
    const std::string name = at->path().filename().string();
    std::error_code unknown;
    const bool is_folder = at->is_directory(unknown);
    if (name.starts_with('.') || unknown) continue;
    if (is_folder || has_extension(name, extensions)) list.entries.push_back({name, is_folder});
  }
  if (fault) list.fault = folder.string() + ": " + fault.message();
  std::ranges::sort(list.entries, {}, [](const FileEntry& entry) {
    return std::tuple(!entry.is_folder, lower(entry.name), entry.name);
  });
  return list;
}

std::vector<FileEntry> matching(const std::vector<FileEntry>& entries, const std::string& text) {
  const std::string wanted = lower(text);
  std::vector<FileEntry> found;
  for (const FileEntry& entry : entries) {
    if (lower(entry.name).find(wanted) != std::string::npos) found.push_back(entry);
  }
  return found;
}

fs::path path_in(const fs::path& folder, const std::string& text) {
  const char* const home = std::getenv("HOME");
  if (home && (text == "~" || text.starts_with("~/"))) {
    return (fs::path(home) / text.substr(std::min<size_t>(2, text.size()))).lexically_normal();
  }
  const fs::path path = (folder / text).lexically_normal();
  // "folder/" becomes "folder".
  return path.has_filename() || !path.has_relative_path() ? path : path.parent_path();
}

fs::path with_extension(fs::path path, const std::vector<std::string>& extensions) {
  if (!has_extension(path, extensions)) path += extensions.front();
  return path;
}

}  // namespace kinome::viewer

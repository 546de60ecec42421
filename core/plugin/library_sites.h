#pragma once

#include <string>

namespace kinome {

/// Scope in which a plugin's library is loaded. Records the data of plugin_at() and
/// plugin_being_loaded().
class LibraryLoading {
 public:
  /// Makes plugin_being_loaded() return `plugin` during the lifetime of this object.
  explicit LibraryLoading(const std::string& plugin);
  LibraryLoading(const LibraryLoading&) = delete;
  LibraryLoading& operator=(const LibraryLoading&) = delete;
  ~LibraryLoading();
  /// Records the library, which has been loaded and contains `symbol`.
  void finish(const void* symbol);

 private:
  const char* name_;  ///< never freed
};

}  // namespace kinome

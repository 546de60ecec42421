#pragma once

#include <string>

namespace kinome {

/// Where plugin_at() and plugin_being_loaded() know it from.
class LibraryLoading {
 public:
  /// A library is about to be loaded, until this ends.
  explicit LibraryLoading(const std::string& plugin);
  LibraryLoading(const LibraryLoading&) = delete;
  LibraryLoading& operator=(const LibraryLoading&) = delete;
  ~LibraryLoading();
  /// It was, and `symbol` is one of its own.
  void finish(const void* symbol);

 private:
  const char* name_;  ///< for ever
};

}  // namespace kinome

#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinome/error.h"
#include "kinome/instruction_set.h"
#include "kinome/plugin.h"

namespace kinome {

/// Thrown if a plugin's library exists but can't be used. Reported once for all of its objects.
class KINOME_EXPORT UnusablePlugin : public Error {
 public:
  using Error::Error;
};

/// Finds plugins in a list of folders, as DIR/CATEGORY/NAME.so, and loads them on first use.
/// Folders named after instruction sets may contain the same plugin compiled for those
/// (DIR/CATEGORY/x86-64-v4/NAME.so); the registry takes the best one allowed. It reads and compares
/// the ABI key of a library before it runs any of its code. Libraries are never unloaded, because
/// an exception thrown by one may outlive everything else. Not thread-safe.
class KINOME_EXPORT PluginRegistry {
 public:
  /// Searches the folders in order, skipping missing ones. Loads no library that needs more than
  /// `instruction_set`, which the processor must support.
  explicit PluginRegistry(std::vector<std::string> folders,
                          InstructionSet instruction_set = choose_instruction_set());

  /// Returns `extra` (--plugin-path), then KINOME_PLUGIN_PATH (separated by ':'), then the folder
  /// `plugins` beside the program's folder (build tree) and `../lib/kinome/plugins` (install tree).
  static std::vector<std::string> default_folders(const std::vector<std::string>& extra = {});

  /// Returns a plugin, loading it if necessary. Throws Error at `where` if the plugin is unknown
  /// (with the nearest name), is not a plugin, has another ABI, needs a higher instruction set than
  /// the registry's, or can't be loaded.
  const PluginDescriptor& find(Category category, const std::string& name,
                               const Location& where = {});
  /// Creates an object. First checks `props` against the plugin's table: unknown names (with the
  /// nearest known one), types, required parameters and counts; throws all errors as Errors.
  /// Afterwards checks that the constructor read every property.
  std::shared_ptr<Object> create(Properties& props);
  /// Creates an object of a plugin that find() has returned, in the same way. Thread-safe.
  static std::shared_ptr<Object> create(const PluginDescriptor& plugin, Properties& props);

  /// Names of all plugins in a category, including aliases, sorted. Loads nothing.
  std::vector<std::string> names(Category category) const;
  /// True if names() contains the name. Takes much less time, because it lists no folder.
  bool has(Category category, const std::string& name) const;
  /// Instruction sets that a plugin is compiled for, the baseline first; empty if the plugin is
  /// unknown.
  std::vector<InstructionSet> instruction_sets(Category category, const std::string& name) const;
  /// Highest instruction set that may be used.
  InstructionSet instruction_set() const { return instruction_set_; }
  /// "category/name" of the loaded plugins, in loading order.
  const std::vector<std::string>& loaded() const { return loaded_names_; }
  /// Seconds spent loading libraries.
  double seconds() const { return seconds_; }

 private:
  std::vector<std::string> folders_;
  InstructionSet instruction_set_;
  std::map<std::pair<Category, std::string>, const PluginDescriptor*> loaded_;
  std::vector<std::string> loaded_names_;
  /// unavailable plugins, with the reason
  std::map<std::pair<Category, std::string>, std::string> missing_;
  double seconds_ = 0;
};

}  // namespace kinome

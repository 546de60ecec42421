#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kinome/error.h"
#include "kinome/instruction_set.h"
#include "kinome/plugin.h"

namespace kinome {

/// A plugin's library exists but can't be used. Reported once, however many objects ask for it.
class KINOME_EXPORT UnusablePlugin : public Error {
 public:
  using Error::Error;
};

/// Finds plugins by category and name in a list of folders, as DIR/CATEGORY/NAME.so, and loads each
/// on first use. Beside NAME.so, folders named after instruction sets may hold the same plugin
/// built for those (DIR/CATEGORY/x86-64-v4/NAME.so): the best that the registry may use is taken.
/// Before any code of a library runs, its ABI key is read from the file and compared.
/// Libraries are never unloaded: an exception that one threw may outlive everything else.
/// Not thread-safe.
class KINOME_EXPORT PluginRegistry {
 public:
  /// Folders are searched in order; missing ones are skipped. No library is loaded that needs more
  /// than `instruction_set`, which the processor must have.
  explicit PluginRegistry(std::vector<std::string> folders,
                          InstructionSet instruction_set = choose_instruction_set());

  /// `extra` (--plugin-path), then KINOME_PLUGIN_PATH (separated by ':'), then `plugins` beside
  /// the program's folder (build tree) and `../lib/kinome/plugins` (install tree).
  static std::vector<std::string> default_folders(const std::vector<std::string>& extra = {});

  /// Loads it if need be. Error at `where`: no such plugin (with the nearest name), no plugin at
  /// all, another ABI, an instruction set beyond the registry's, or it can't be loaded.
  const PluginDescriptor& find(Category category, const std::string& name,
                               const Location& where = {});
  /// Checks `props` against the plugin's table (unknown names with the nearest known one, types,
  /// required ones, counts: all that is wrong, as Errors), creates the object, then checks that
  /// every property was read.
  std::shared_ptr<Object> create(Properties& props);

  /// Names (aliases included) that exist in a category, sorted, without loading anything.
  std::vector<std::string> names(Category category) const;
  /// What a plugin is built for, the baseline first; nothing where there is no such plugin.
  std::vector<InstructionSet> instruction_sets(Category category, const std::string& name) const;
  /// The best that may be used.
  InstructionSet instruction_set() const { return instruction_set_; }
  /// "category/name" of what was loaded, in order.
  const std::vector<std::string>& loaded() const { return loaded_names_; }
  /// Seconds spent in loading libraries.
  double seconds() const { return seconds_; }

 private:
  std::vector<std::string> folders_;
  InstructionSet instruction_set_;
  std::map<std::pair<Category, std::string>, const PluginDescriptor*> loaded_;
  std::vector<std::string> loaded_names_;
  std::map<std::pair<Category, std::string>, std::string> missing_;  ///< what there isn't, and why
  double seconds_ = 0;
};

}  // namespace kinome

#pragma once

#include <set>
#include <string>
#include <vector>

#include "kinome/plugin.h"

namespace kinome {

/// Returns the plugin's parameter of this name, or nullptr.
const Parameter* find_row(const PluginDescriptor& plugin, const std::string& name);
/// Values that the scene contains, but that are missing from Properties because of an error of
/// their own. They are not reported as missing.
struct Lost {
  std::set<std::string> names;    ///< names of parameters
  std::set<Category> categories;  ///< categories of nested objects
  bool anything = false;          ///< a value with unknown name or category is missing
};
/// Checks the entries of `props` against the plugin's parameter table: names, types, counts of
/// nested objects, and required parameters. Returns all errors.
std::vector<Error> check_parameters(const Properties& props, const PluginDescriptor& plugin,
                                    const Lost& lost = {});
/// A value for a parameter that the plugin ignores. The pointers are valid as long as the plugin
/// and the Properties.
struct IgnoredEntry {
  const Parameter* row;
  const Properties::Entry* entry;
};
/// Returns the entries of `props` that the plugin ignores (Parameter::ignored), and marks them as
/// read.
std::vector<IgnoredEntry> take_ignored(const Properties& props, const PluginDescriptor& plugin);
/// Throws an Error that lists the entries that the plugin's constructor hasn't read, if any.
void check_all_read(const Properties& props);

}  // namespace kinome

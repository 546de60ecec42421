#pragma once

#include <set>
#include <string>
#include <vector>

#include "kinome/plugin.h"

namespace kinome {

/// The plugin's parameter of that name; nullptr if it has none.
const Parameter* find_row(const PluginDescriptor& plugin, const std::string& name);
/// What the scene gives to an object, but has a mistake of its own: not to be missed.
struct Lost {
  std::set<std::string> names;    ///< of parameters
  std::set<Category> categories;  ///< of nested objects
  bool anything = false;          ///< of what, isn't known
};
/// Checks the entries of `props` against the plugin's parameter table: names, types, counts of
/// nested objects, required ones. All that is wrong.
std::vector<Error> check_parameters(const Properties& props, const PluginDescriptor& plugin,
                                    const Lost& lost = {});
/// A value in the scene for a row that the plugin ignores. The pointers live as long as the plugin
/// and the Properties.
struct IgnoredEntry {
  const Parameter* row;
  const Properties::Entry* entry;
};
/// Returns the entries of `props` that the plugin ignores (Parameter::ignored), and marks them as
/// read.
std::vector<IgnoredEntry> take_ignored(const Properties& props, const PluginDescriptor& plugin);
/// An Error that lists what the plugin's constructor left unread.
void check_all_read(const Properties& props);

}  // namespace kinome

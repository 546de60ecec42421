#pragma once

#include "kinome/plugin.h"

namespace kinome {

/// The plugin's parameter of that name; nullptr if it has none.
const Parameter* find_row(const PluginDescriptor& plugin, const std::string& name);
/// Checks the entries of `props` against the plugin's parameter table: names, types, counts of
/// nested objects, required ones. Throws Error at the first that is wrong.
void check_parameters(const Properties& props, const PluginDescriptor& plugin);
/// An Error that lists what the plugin's constructor left unread.
void check_all_read(const Properties& props);

}  // namespace kinome

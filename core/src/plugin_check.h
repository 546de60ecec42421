#pragma once

#include "kinome/plugin.h"

namespace kinome {

/// Checks the entries of `props` against the plugin's parameter table: names, types, counts of
/// nested objects, required ones. Throws Error at the first that is wrong.
void check_parameters(const Properties& props, const PluginDescriptor& plugin);
/// An Error that lists what the plugin's constructor left unread.
void check_all_read(const Properties& props);

}  // namespace kinome

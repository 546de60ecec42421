#pragma once

#include <map>
#include <string>

#include "loader/saved_scene.h"

namespace kinome::loader {

/// A scene as XML from its nodes alone, in an order and form of its own.
std::string generated_scene(const Expansion& expansion, const SavedScene& saved);

/// Writes an edited scene as the file `path`, with its includes and arrays beside it, as a patched
/// text if that can be, otherwise as a generated one. `name`: the file that it was read from.
/// Throws Error where that can't be, and nothing is written then; where the disk fails, files
/// beside it may be there, but `path` is what it was.
void save_scene(const Expansion& expansion, const std::string& name,
                const std::map<std::string, std::string>& defines, SavedScene& saved,
                const std::string& path);

}  // namespace kinome::loader

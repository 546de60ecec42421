#pragma once

#include <map>
#include <string>

#include "editor/saving/saved_scene.h"

namespace kinome::loader {

/// Returns a scene as XML, generated from its nodes without their original text.
std::string generated_scene(const Expansion& expansion, const SavedScene& saved);

/// Writes an edited scene to the file `path`, and its includes and arrays beside it. The text is
/// that of the original file, `name`, with patches if that is possible, otherwise generated. Throws
/// Error before writing anything if the scene can't be saved. If writing fails, files beside it may
/// have been written, but `path` is unchanged.
void save_scene(const Expansion& expansion, const std::string& name,
                const std::map<std::string, std::string>& defines, SavedScene& saved,
                const std::string& path);

}  // namespace kinome::loader

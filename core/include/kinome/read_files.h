#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// Registers a file that a scene or a command reads, so that it is never overwritten: all writers
/// of the core (see kinome/image.h) refuse such a path. The registration lasts until the process
/// ends, or as long as the SceneEditor that reads the file. Files that Properties::file() finds are
/// registered already; a plugin registers only files that those name in turn. Thread-safe.
KINOME_EXPORT void note_read_file(const std::string& path);

/// Returns whether `path` names a registered file, under its own name, a link or another name.
/// Thread-safe.
KINOME_EXPORT bool is_read_file(const std::string& path);

}  // namespace kinome

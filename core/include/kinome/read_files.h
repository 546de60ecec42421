#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// Registers a file that a scene or a command reads, so that it is never overwritten: all writers
/// of the core (see kinome/image.h) refuse such a path. The registration lasts as long as the
/// SceneEditor that reads the file; a file that is read without one is registered only after
/// protect_read_files(). Files that Properties::file() finds are registered already; a plugin
/// registers only files that those name in turn. Thread-safe.
KINOME_EXPORT void note_read_file(const std::string& path);

/// From now on, registers all files until the process ends. A program calls it at its start. A
/// library doesn't, because its users may replace a file once its scene is gone.
KINOME_EXPORT void protect_read_files();

/// Returns whether `path` names a registered file, under its own name, a link or another name.
/// Thread-safe.
KINOME_EXPORT bool is_read_file(const std::string& path);

}  // namespace kinome

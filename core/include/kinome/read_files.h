#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// Returns the bytes of a file. Throws Error at the file, with the system's reason, if it can't be
/// read or doesn't fit in memory.
KINOME_EXPORT std::string file_contents(const std::string& path);

/// Registers a file that a scene or a command reads, so that it is never overwritten: all of
/// Kinome's file writers refuse its path. The registration lasts as long as the SceneEditor that
/// reads the file; without an editor, files are registered only after protect_read_files().
/// Properties::file() registers its files itself, so a plugin registers only the files that are
/// named in them. Thread-safe.
KINOME_EXPORT void record_read_file(const std::string& path);

/// Registers all files read from now on, until the process ends. Programs call it at their start.
/// Libraries don't, because their users may replace a file once its scene is gone.
KINOME_EXPORT void protect_read_files();

/// True if `path` names a registered file, directly, by a link or under another name. Thread-safe.
KINOME_EXPORT bool is_read_file(const std::string& path);

}  // namespace kinome

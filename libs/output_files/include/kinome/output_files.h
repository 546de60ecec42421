#pragma once

#include <string>

#include "kinome/export.h"

namespace kinome {

/// Writes a text file. Like all of Kinome's writers, it writes a temporary file in the same folder
/// and renames it, so that `path` is either complete or unchanged. Throws Error if the folder is
/// not writable or the disk is full.
KINOME_EXPORT void write_text(const std::string& path, const std::string& text);
/// Waits until a written file and its folder entry are on the disk. Throws Error.
KINOME_EXPORT void sync_file(const std::string& path);
/// Deletes the temporary files of interrupted writers. Async-signal-safe.
KINOME_EXPORT void remove_temporary_files() noexcept;
/// Throws Error if a file at `path` can't be created now: the folder is missing or not writable, or
/// `path` is a folder. Call it before a long render.
KINOME_EXPORT void check_writable(const std::string& path);

}  // namespace kinome

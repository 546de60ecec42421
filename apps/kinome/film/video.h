#pragma once

#include <string>

namespace kinome::app {

/// Returns whether ffmpeg, which encodes videos, is in PATH.
bool has_ffmpeg();

/// Encodes PNG frames as an MP4 file (H.264). `pattern` names the frames as for ffmpeg, such as
/// "film-frames/%04d.png", counted from 0; `rate` is in frames per second. Replaces the file at
/// `path` only on success; throws Error on failure.
void make_video(const std::string& pattern, double rate, const std::string& path);

}  // namespace kinome::app

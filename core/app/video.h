#pragma once

#include <string>

namespace kinome::app {

/// Whether the system has ffmpeg, which makes videos.
bool has_ffmpeg();

/// An MP4 (H.264) of PNG frames: `pattern` as ffmpeg's, "film-frames/%04d.png", counted from 0;
/// `rate`: frames a second. The file is whole, or what it was before. Throws Error.
void make_video(const std::string& pattern, double rate, const std::string& path);

}  // namespace kinome::app

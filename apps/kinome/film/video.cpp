#include "film/video.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "kinome/error.h"
#include "session/scratch_folder.h"
#include "shell.h"

namespace kinome::app {
namespace {

/// Runs a command by the shell. Returns 0 on success, and the last line that it prints to stderr.
std::pair<int, std::string> run(const std::string& command) {
  std::FILE* const pipe = popen((command + " 2>&1 >/dev/null </dev/null").c_str(), "re");
  if (!pipe) return {-1, std::strerror(errno)};
  std::string text;
  char buffer[4096];
  while (const size_t count = std::fread(buffer, 1, sizeof buffer, pipe)) {
    text.append(buffer, count);
  }
  const int status = pclose(pipe);
  while (text.ends_with('\n')) text.pop_back();
  return {status, text.substr(text.rfind('\n') + 1)};
}

}  // namespace

bool has_ffmpeg() {
  return run("command -v ffmpeg").first == 0;
}

void make_video(const std::string& pattern, double rate, const std::string& path) {
  const ScratchFolder scratch(path);
  const std::string unfinished = scratch.file("film.mp4");
  // Most players require even sizes, 4:2:0 chroma subsampling, and tags for the colour space. The
  // prefix "file:" protects names that begin with a dash.
  const auto [status, last_line] = run(fmt::format(
      "ffmpeg -nostdin -y -loglevel error -framerate {} -i {} -vf "
      "'pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p' "
      "-c:v libx264 -crf 20 -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1 "
      "-movflags +faststart {}",
      rate, quoted("file:" + pattern), quoted("file:" + unfinished)));
  std::error_code failed;
  if (status == 0) std::filesystem::rename(unfinished, path, failed);
  if (status == 0 && !failed) return;
  const std::string why = failed ? failed.message() : last_line;
  throw Error(
      fmt::format("-o {}: ffmpeg can't encode {}{}", path, pattern, why.empty() ? "" : ": " + why));
}

}  // namespace kinome::app

#include "film/video.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "session/scratch_folder.h"
#include "kinome/error.h"

extern char** environ;

namespace kinome::app {
namespace {

namespace fs = std::filesystem;

struct Ended {
  int status = -1;        ///< as waitpid() returns it; -1 if the program wasn't started
  std::string last_line;  ///< of stderr
};

/// Runs a program to its end. `words` are its name and arguments.
Ended run(const std::vector<std::string>& words) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {-1, std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  Ended ended;
  std::string text;
  char buffer[4096];
  ssize_t count = 0;
  while ((count = read(ends[0], buffer, sizeof buffer)) > 0 || (count < 0 && errno == EINTR)) {
    if (count > 0) text.append(buffer, static_cast<size_t>(count));
  }
  close(ends[0]);
  if (error != 0) return {-1, std::strerror(error)};
  while (waitpid(child, &ended.status, 0) < 0 && errno == EINTR) {
  }
  while (text.ends_with('\n')) text.pop_back();
  ended.last_line = text.substr(text.rfind('\n') + 1);
  return ended;
}

}  // namespace

bool has_ffmpeg() {
  const char* const paths = std::getenv("PATH");
  std::string rest = paths ? paths : "";
  while (!rest.empty()) {
    const size_t end = std::min(rest.find(':'), rest.size());
    const std::string program = (fs::path(rest.substr(0, end)) / "ffmpeg").string();
    if (access(program.c_str(), X_OK) == 0) return true;
    rest.erase(0, end + 1);
  }
  return false;
}

void make_video(const std::string& pattern, double rate, const std::string& path) {
  const ScratchFolder scratch(path);
  const std::string unfinished = scratch.file("film.mp4");
  // Most players require even sizes, 4:2:0 chroma subsampling, and tags for the colour space. The
  // prefix "file:" protects names that begin with a dash.
  const auto file = [](const std::string& name) { return "file:" + name; };
  const Ended ended =
      run({"ffmpeg",
           "-nostdin",
           "-y",
           "-loglevel",
           "error",
           "-framerate",
           fmt::format("{}", rate),
           "-i",
           file(pattern),
           "-vf",
           "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
           "-c:v",
           "libx264",
           "-crf",
           "20",
           "-colorspace",
           "bt709",
           "-color_primaries",
           "bt709",
           "-color_trc",
           "iec61966-2-1",
           "-movflags",
           "+faststart",
           file(unfinished)});
  std::error_code failed;
  if (ended.status == 0) fs::rename(unfinished, path, failed);
  if (ended.status == 0 && !failed) return;
  const std::string why = failed ? failed.message() : ended.last_line;
  throw Error(
      fmt::format("-o {}: ffmpeg can't encode {}{}", path, pattern, why.empty() ? "" : ": " + why));
}

}  // namespace kinome::app

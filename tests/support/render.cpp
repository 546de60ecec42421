#include "support/render.h"

#include <functional>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include "kinome/clustered_light.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Pipe {
  int read_end = -1;
  int write_end = -1;
};

Pipe open_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
  return {ends[0], ends[1]};
}

/// Starts a program in its own process group, so that a timeout also ends its children.
pid_t start_process(const std::vector<std::string>& arguments, const Pipe& out, const Pipe& err) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  // Both parent and child call it, so that the group exists before either continues.
  setpgid(child, child);
  if (child > 0) return child;
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(out.write_end, STDOUT_FILENO);
  dup2(err.write_end, STDERR_FILENO);
  execvp(argv[0], argv.data());
  _exit(127);
}

/// Appends the data that can be read now. Returns false at the end of the stream.
bool drain(int descriptor, std::string& text) {
  char buffer[4096];
  const ssize_t bytes = read(descriptor, buffer, sizeof buffer);
  if (bytes <= 0) return false;
  text.append(buffer, static_cast<size_t>(bytes));
  return true;
}

/// Reads both streams until both have ended. Returns false if the deadline comes first.
bool collect(Pipe out, Pipe err, Clock::time_point deadline, ProcessResult& result) {
  pollfd streams[2] = {{out.read_end, POLLIN, 0}, {err.read_end, POLLIN, 0}};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    if (poll(streams, 2, static_cast<int>(left)) < 0) continue;
    if (streams[0].revents && !drain(streams[0].fd, result.out)) streams[0].fd = -1;
    if (streams[1].revents && !drain(streams[1].fd, result.err)) streams[1].fd = -1;
  }
  return true;
}

}  // namespace

PluginRegistry& registry() {
  static PluginRegistry instance([] {
    auto folders = PluginRegistry::default_folders();  // KINOME_PLUGIN_PATH first
    folders.push_back(KINOME_TEST_PLUGINS);
    return folders;
  }());
  return instance;
}

std::shared_ptr<Object> make_object(const std::string& xml) {
  return load_object_from_string(xml, "test.xml", {}, registry());
}

std::unique_ptr<Scene> scene_from(const std::string& xml) {
  const bool whole = xml.find("<scene") != std::string::npos;
  return load_scene_from_string(whole ? xml : "<scene version=\"3.0.0\">" + xml + "</scene>",
                                "test.xml", {}, registry());
}

Image render_scene(const Scene& scene, uint64_t seed, unsigned threads) {
  RenderOptions options;
  options.seed = seed;
  options.threads = threads;
  RenderContext context(options);
  return render(scene, *scene.sensors().at(0), context);
}

std::optional<LightPoints> light_points_of(const Emitter& emitter, uint32_t count, uint64_t seed) {
  static const std::unique_ptr<Scene> scene = scene_from("<shape type=\"rectangle\"/>");
  RenderContext context({.threads = 1, .seed = seed});
  return light_points_of(emitter, *scene, context, count);
}

namespace {

/// Estimates R, G and B of all pixels from the renders that `make` returns, in Image order.
std::vector<Estimate> estimate(int renders, uint64_t first_seed,
                               const std::function<std::vector<double>(uint64_t)>& make) {
  std::vector<Moments> moments;
  for (int i = 0; i < renders; ++i) {
    const std::vector<double> values = make(first_seed + static_cast<uint64_t>(i));
    moments.resize(values.size());
    for (size_t k = 0; k < values.size(); ++k) moments[k].add(values[k]);
  }
  std::vector<Estimate> estimates;
  estimates.reserve(moments.size());
  for (const Moments& m : moments) estimates.push_back({m.mean(), m.variance_of_mean()});
  return estimates;
}

/// Returns the sums over tiles, one tile after another.
std::vector<double> colours(const Image& image, int tile = 1) {
  const int columns = (image.width + tile - 1) / tile, rows = (image.height + tile - 1) / tile;
  std::vector<double> values(static_cast<size_t>(columns) * rows * 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      double* const sum = &values[3 * (static_cast<size_t>(y / tile) * columns + x / tile)];
      for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y, c);
    }
  }
  return values;
}

}  // namespace

std::vector<Estimate> estimate_pixels(const Scene& scene, int renders, uint64_t first_seed) {
  return estimate(renders, first_seed,
                  [&](uint64_t seed) { return colours(render_scene(scene, seed)); });
}

std::vector<Estimate> estimate_tiles(const Scene& scene, int renders, int tile,
                                     uint64_t first_seed) {
  return estimate(renders, first_seed,
                  [&](uint64_t seed) { return colours(render_scene(scene, seed), tile); });
}

std::vector<Estimate> estimate_differences(const Scene& a, const Scene& b, int renders, int tile,
                                           uint64_t first_seed) {
  return estimate(renders, first_seed, [&](uint64_t seed) {
    std::vector<double> values = colours(render_scene(a, seed), tile);
    const std::vector<double> others = colours(render_scene(b, seed), tile);
    for (size_t k = 0; k < values.size(); ++k) values[k] -= others.at(k);
    return values;
  });
}

TemporaryFolder::TemporaryFolder() {
  folder_ = (fs::temp_directory_path() / "kinome-test-XXXXXX").string();
  if (!mkdtemp(folder_.data())) throw std::runtime_error("can't make " + folder_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& contents) const {
  fs::create_directories(fs::path(path(name)).parent_path());
  std::ofstream file(path(name), std::ios::binary);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  if (!file.flush()) throw std::runtime_error("can't write " + path(name));
  return path(name);
}

ProcessResult run_process(const std::vector<std::string>& arguments, double timeout_seconds) {
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(timeout_seconds));
  const Pipe out = open_pipe();
  const Pipe err = open_pipe();
  const pid_t child = start_process(arguments, out, err);
  close(out.write_end);
  close(err.write_end);
  ProcessResult result;
  if (!collect(out, err, deadline, result)) {
    kill(-child, SIGKILL);
    result.err += "\n[killed after " + std::to_string(timeout_seconds) + " s]";
  }
  close(out.read_end);
  close(err.read_end);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace kinome::test

// kinome-stress [--seconds N] [--scenes N] [--seed S] [--first I] [--jobs J] [--out FOLDER]
// kinome-stress --replay FILE
//
// Renders random scenes, each in its own process, and reports violated conditions (check.h).
// Reduces the scene of a finding as long as the finding persists, and writes it to
// FOLDER/SEED-I/scene.xml with its files and the command that reproduces it. The run as a whole
// fails if it refuses most scenes or compares hardly anything. The last line is `N passed, M
// failed`.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>

#include "check.h"
#include "generate.h"
#include "kinome/log.h"
#include "process.h"
#include "shrink.h"
#include "support/render.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  double seconds = 20;
  uint64_t scenes = std::numeric_limits<uint64_t>::max();  ///< maximum
  uint64_t seed = 1;
  uint64_t first = 0;
  unsigned jobs = std::max(1u, std::thread::hardware_concurrency());
  std::string out = "stress-findings";
  std::string replay;
};

/// A run gives no result if it refuses most scenes, or leaves too many comparisons open. With at
/// most kFewScenes scenes, these fractions are too random to be tested.
constexpr uint64_t kFewScenes = 20;
constexpr double kMaxRefused = 0.5, kMaxOpen = 0.1, kMaxExcused = 0.005;

// ---- the run ----

struct Tally {
  uint64_t scenes = 0, refused = 0, comparisons = 0, open = 0, excused = 0, failed = 0;
  std::map<std::string, int> reasons;  ///< number of refusals by reason

  /// Returns the reason why the run as a whole gives no result; empty if it does.
  std::string shortcoming() const {
    if (scenes == 0) return "no scene was checked";
    if (scenes <= kFewScenes) return "";
    if (comparisons == 0) return "nothing was compared";
    if (static_cast<double>(refused) > kMaxRefused * static_cast<double>(scenes)) {
      return "most scenes were refused";
    }
    if (static_cast<double>(open) > kMaxOpen * static_cast<double>(comparisons)) {
      return "too many comparisons are open";
    }
    if (static_cast<double>(excused) > kMaxExcused * static_cast<double>(comparisons)) {
      return "too many differences are left to luck";
    }
    return "";
  }
};

void keep(const Options& options, uint64_t index, const Check& check) {
  const Finding& finding = check.report().findings.front();
  const std::string folder = fmt::format("{}/{}-{}", options.out, options.seed, index);
  fs::create_directories(folder);
  RandomScene scene = random_scene(options.seed, index, folder);
  const std::string generated = scene.root.text();
  std::ofstream(folder + "/generated.xml") << generated;
  scene.root = shrink(scene.root, finding, scene.is_valid, folder);
  fs::remove(folder + "/report");
  std::string text = scene.root.text();
  for (const Method& method : all_methods()) {
    if (method.name != finding.method) continue;
    text.insert(text.find('\n') + 1, integrator_of(method, text) + "\n");
  }
  std::string comment = fmt::format("{}, {}: {}", finding.kind, finding.method, finding.text);
  for (size_t at = 0; (at = comment.find("--", at)) != std::string::npos;) comment.erase(at, 1);
  // A replay takes the first <integrator for the integrator.
  std::erase(comment, '<');
  std::ofstream(folder + "/scene.xml") << "<!-- " << comment << " -->\n" << text;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == "scene.xml" || name == "generated.xml") continue;
    if (generated.find(name) == std::string::npos) fs::remove(entry.path());
  }
  std::cout << fmt::format("scene {}: {}, {}: {}\n  kinome-stress --replay {}/scene.xml\n", index,
                           finding.kind, finding.method, finding.text, folder)
            << std::flush;
}

void count(const Options& options, uint64_t index, const Check& check, Tally& tally) {
  const CheckReport& report = check.report();
  ++tally.scenes;
  tally.comparisons += static_cast<uint64_t>(report.comparisons);
  tally.open += static_cast<uint64_t>(report.open);
  tally.excused += report.excuses.size();
  for (const std::string& excuse : report.excuses) {
    const std::string folder = fmt::format("{}/{}-{}-open", options.out, options.seed, index);
    fs::create_directories(folder);
    std::ofstream(folder + "/scene.xml") << random_scene(options.seed, index, folder).root.text();
    std::cout << fmt::format("scene {}: open: {}\n  {}/scene.xml\n", index, excuse, folder)
              << std::flush;
  }
  if (!report.refused.empty()) {
    ++tally.refused;
    ++tally.reasons[reason_of(report.refused)];
  }
  if (!report.findings.empty()) {
    ++tally.failed;
    keep(options, index, check);
  }
}

/// Loads all plugins once, for all child processes.
void load_plugins() {
  for (const Category category :
       {Category::kBsdf, Category::kEmitter, Category::kFilm, Category::kIntegrator,
        Category::kReconstructionFilter, Category::kSampler, Category::kSensor, Category::kShape,
        Category::kTexture}) {
    for (const std::string& name : registry().names(category)) registry().find(category, name);
  }
}

int run(const Options& options) {
  const TemporaryFolder folder;
  load_plugins();
  const auto start = Clock::now();
  std::map<uint64_t, std::unique_ptr<Check>> running;
  Tally tally;
  uint64_t next = options.first;
  const auto in_time = [&] {
    return next - options.first < options.scenes &&
           std::chrono::duration<double>(Clock::now() - start).count() < options.seconds;
  };
  while (in_time() || !running.empty()) {
    while (in_time() && running.size() < options.jobs) {
      const uint64_t index = next++;
      running[index] = std::make_unique<Check>(
          folder.path(std::to_string(index)), [&, index](const std::string& own) {
            const RandomScene scene = random_scene(options.seed, index, own);
            CheckTask task;
            task.is_valid = scene.is_valid;
            return check_scene(scene.root.text(), own, task);
          });
    }
    for (auto it = running.begin(); it != running.end();) {
      if (!it->second->poll()) {
        ++it;
        continue;
      }
      count(options, it->first, *it->second, tally);
      fs::remove_all(it->second->folder());
      it = running.erase(it);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::cout << fmt::format("seed {}: {} scenes, {} refused, {} comparisons, {} of them open\n",
                           options.seed, tally.scenes, tally.refused, tally.comparisons,
                           tally.open);
  for (const auto& [reason, times] : tally.reasons) {
    std::cout << fmt::format("  refused {} x: {}\n", times, reason);
  }
  uint64_t failed = tally.failed;
  if (const std::string shortcoming = tally.shortcoming(); !shortcoming.empty()) {
    std::cout << "the run as a whole failed: " << shortcoming << "\n";
    ++failed;
  }
  std::cout << tally.scenes - tally.failed << " passed, " << failed << " failed\n";
  return failed == 0 ? 0 : 1;
}

int replay(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("'" + file + "' can't be read");
  std::stringstream contents;
  contents << in.rdbuf();
  std::string text = contents.str();
  // Each method adds its own integrator.
  const size_t begin = text.find("<integrator");
  if (begin != std::string::npos) {
    const size_t tag_end = text.find('>', begin);
    const bool is_empty = text[tag_end - 1] == '/';
    const size_t end = is_empty ? tag_end + 1 : text.find("</integrator>", begin) + 13;
    text.erase(begin, end - begin);
  }
  const TemporaryFolder folder;
  const std::string home = fs::absolute(file).parent_path().string();
  int failed = 0, passed = 0;
  for (const Method& method : all_methods()) {
    CheckTask task;
    task.only = method.name;
    Check check(folder.path(method.name),
                [&](const std::string&) { return check_scene(text, home, task); });
    const CheckReport& report = check.wait();
    std::string line = method.name + ": ";
    if (!report.refused.empty()) line += "refused: " + report.refused;
    for (const Finding& f : report.findings) line += f.kind + ", " + f.text + "; ";
    if (report.refused.empty() && report.findings.empty()) line += "passed";
    for (const std::string& excuse : report.excuses) line += "; open: " + excuse;
    std::cout << line << "\n";
    // Nothing was checked in a refused scene. If other methods render it, the refusal is a finding,
    // too.
    (report.findings.empty() && report.refused.empty() ? passed : failed) += 1;
  }
  std::cout << passed << " passed, " << failed << " failed\n";
  return failed == 0 ? 0 : 1;
}

bool read_options(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 == argc) return false;
    const char* const value = argv[i + 1];
    char* end = nullptr;
    const auto whole = [&] { return std::strtoull(value, &end, 10); };
    if (name == "--seconds") {
      options.seconds = std::strtod(value, &end);
    } else if (name == "--scenes") {
      options.scenes = whole();
    } else if (name == "--seed") {
      options.seed = whole();
    } else if (name == "--first") {
      options.first = whole();
    } else if (name == "--jobs") {
      options.jobs = static_cast<unsigned>(whole());
    } else if (name == "--out") {
      options.out = value;
    } else if (name == "--replay") {
      options.replay = value;
    } else {
      return false;
    }
    if (end && *end != '\0') return false;
  }
  return options.jobs > 0;
}

}  // namespace
}  // namespace kinome::test

int main(int argc, char** argv) {
  using namespace kinome::test;
  Options options;
  if (!read_options(argc, argv, options)) {
    std::cerr << "kinome-stress [--seconds N] [--scenes N] [--seed S] [--first I] [--jobs J]\n"
                 "              [--out FOLDER]\n"
                 "kinome-stress --replay FILE\n";
    return 2;
  }
  kinome::set_log_level(kinome::LogLevel::kQuiet);
  try {
    return options.replay.empty() ? run(options) : replay(options.replay);
  } catch (const std::exception& error) {
    std::cout << error.what() << "\n0 passed, 1 failed\n";
    return 1;
  }
}

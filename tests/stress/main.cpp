// kinome-stress --seconds N [--seed S] [--first I] [--jobs J] [--out FOLDER]
// kinome-stress --replay FILE
//
// Renders random scenes, each in a process of its own, and says what doesn't hold for any of them
// (check.h). A finding is made smaller while it lasts, and written to FOLDER/SEED-I/scene.xml with
// its files and the command that shows it again. The last line is `N passed, M failed`.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <thread>

#include <fmt/format.h>

#include "check.h"
#include "generate.h"
#include "kinome/log.h"
#include "support/render.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  double seconds = 20;
  uint64_t seed = 1;
  uint64_t first = 0;
  unsigned jobs = std::max(1u, std::thread::hardware_concurrency());
  std::string out = "stress-findings";
  std::string replay;
};

constexpr double kPatience = 120;  ///< seconds for one scene, of which most take a fraction of one
constexpr double kShrinking = 40;  ///< seconds for one finding
constexpr rlim_t kMemory = rlim_t{4} << 30;

// ---- one scene, in a process of its own ----

void write_report(const CheckReport& report, const std::string& file) {
  std::ofstream out(file);
  out << report.comparisons << " " << report.open << "\n" << report.refused << "\n";
  for (const Finding& f : report.findings) {
    out << f.kind << "\t" << f.method << "\t" << f.text << "\n";
  }
  out << "end\n";
}
bool read_report(const std::string& file, CheckReport& report) {
  std::ifstream in(file);
  std::string line;
  if (!(in >> report.comparisons >> report.open) || !std::getline(in, line)) return false;
  std::getline(in, report.refused);
  while (std::getline(in, line)) {
    if (line == "end") return true;
    std::istringstream parts(line);
    Finding f;
    std::getline(parts, f.kind, '\t');
    std::getline(parts, f.method, '\t');
    std::getline(parts, f.text);
    report.findings.push_back(f);
  }
  return false;
}

/// A scene that is being checked.
class Check {
 public:
  /// Starts it. `work` makes the report; it may crash.
  template <class Work>
  Check(std::string folder, const Work& work) : folder_(std::move(folder)), start_(Clock::now()) {
    fs::create_directories(folder_);
    child_ = fork();
    if (child_ != 0) return;
    const rlimit memory{kMemory, kMemory};
    setrlimit(RLIMIT_AS, &memory);
    const rlimit core{0, 0};
    setrlimit(RLIMIT_CORE, &core);
    try {
      write_report(work(folder_), folder_ + "/report");
    } catch (const std::exception& error) {
      CheckReport report;
      report.findings.push_back({"exception", "load", error.what()});
      write_report(report, folder_ + "/report");
    }
    _exit(0);
  }

  /// True once it has ended, by itself or for taking too long.
  bool poll() {
    int status = 0;
    const pid_t ended = waitpid(child_, &status, WNOHANG);
    if (ended == 0) {
      if (std::chrono::duration<double>(Clock::now() - start_).count() < kPatience) return false;
      kill(child_, SIGKILL);
      waitpid(child_, &status, 0);
      report_.findings.push_back({"hang", "", fmt::format("more than {} s", kPatience)});
      return true;
    }
    if (WIFSIGNALED(status)) {
      report_.findings.push_back({"crash", "", fmt::format("signal {}", WTERMSIG(status))});
    } else if (!read_report(folder_ + "/report", report_)) {
      report_.findings.push_back({"crash", "", fmt::format("exit status {}", status)});
    }
    return true;
  }
  const CheckReport& wait() {
    while (!poll()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return report_;
  }
  const CheckReport& report() const { return report_; }
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
  Clock::time_point start_;
  pid_t child_ = 0;
  CheckReport report_;
};

// ---- smaller scenes that show the same ----

bool shows(const CheckReport& report, const Finding& finding) {
  for (const Finding& f : report.findings) {
    if (f.kind == finding.kind && (finding.method.empty() || f.method == finding.method)) {
      return true;
    }
  }
  return false;
}

/// Rounder numbers in place of `value`, the simplest first.
std::vector<std::string> rounder(const std::string& value) {
  std::istringstream words(value);
  std::vector<double> numbers;
  double v = 0;
  while (words >> v) numbers.push_back(v);
  if (numbers.empty() || !words.eof()) return {};
  std::vector<std::string> results;
  for (const char* format : {"0", "1", "{:.1g}", "{:.3g}"}) {
    std::string text;
    for (const double x : numbers) {
      text += (text.empty() ? "" : " ") + fmt::format(fmt::runtime(format), x);
    }
    if (text.size() < value.size()) results.push_back(text);
  }
  return results;
}

class Shrinker {
 public:
  Shrinker(std::string folder, Finding finding)
      : folder_(std::move(folder)), finding_(std::move(finding)), start_(Clock::now()) {}

  SceneNode shrink(SceneNode scene) {
    bool is_smaller = true;
    while (is_smaller && in_time()) {
      is_smaller = false;
      // Large parts first; a path is void once something before it is gone.
      for (size_t i = 0; i < paths_of(scene).size() && in_time(); ++i) {
        const NodePath path = paths_of(scene)[i];
        SceneNode without = scene;
        auto& siblings = node_at(without, NodePath(path.begin(), path.end() - 1)).children;
        siblings.erase(siblings.begin() + static_cast<std::ptrdiff_t>(path.back()));
        if (still(without)) {
          scene = without;
          is_smaller = true;
          --i;
        }
      }
    }
    for (const NodePath& path : paths_of(scene)) {
      const size_t count = node_at(scene, path).attributes.size();
      for (size_t a = 0; a < count; ++a) {
        const auto [name, value] = node_at(scene, path).attributes[a];
        if (name == "name" || name == "type") continue;
        for (const std::string& other : rounder(value)) {
          if (!in_time()) return scene;
          SceneNode changed = scene;
          node_at(changed, path).attributes[a].second = other;
          if (still(changed)) {
            scene = changed;
            break;
          }
        }
      }
    }
    return scene;
  }

 private:
  bool in_time() const {
    return std::chrono::duration<double>(Clock::now() - start_).count() < kShrinking;
  }
  bool still(const SceneNode& scene) const {
    Check check(folder_, [&](const std::string& folder) {
      return check_scene(scene.text(), folder, finding_.method == "load" ? "" : finding_.method);
    });
    return shows(check.wait(), finding_);
  }
  std::string folder_;
  Finding finding_;
  Clock::time_point start_;
};

// ---- the run ----

struct Tally {
  uint64_t scenes = 0, refused = 0, comparisons = 0, open = 0, failed = 0;
  std::map<std::string, int> reasons;  ///< that valid scenes were refused for
};

void keep(const Options& options, uint64_t index, const Check& check) {
  const Finding& finding = check.report().findings.front();
  const std::string folder = fmt::format("{}/{}-{}", options.out, options.seed, index);
  fs::create_directories(folder);
  RandomScene scene = random_scene(options.seed, index, folder);
  const std::string generated = scene.root.text();
  std::ofstream(folder + "/generated.xml") << generated;
  scene.root = Shrinker(folder, finding).shrink(scene.root);
  fs::remove(folder + "/report");
  const std::string integrator =
      finding.method.empty() || finding.method == "load" ? "" : integrator_of(finding.method);
  std::string text = scene.root.text();
  text.insert(text.find('\n') + 1, integrator + "\n");
  std::string comment = fmt::format("{}, {}: {}", finding.kind, finding.method, finding.text);
  for (size_t at = 0; (at = comment.find("--", at)) != std::string::npos;) comment.erase(at, 1);
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
  if (!report.refused.empty()) {
    ++tally.refused;
    const size_t end = report.refused.find(':', report.refused.find("scene.xml") + 10);
    ++tally.reasons[report.refused.substr(report.refused.find(':', end + 1) + 1)];
  }
  if (!report.findings.empty()) {
    ++tally.failed;
    keep(options, index, check);
  }
}

/// Children find them loaded.
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
    return std::chrono::duration<double>(Clock::now() - start).count() < options.seconds;
  };
  while (in_time() || !running.empty()) {
    while (in_time() && running.size() < options.jobs) {
      const uint64_t index = next++;
      running[index] = std::make_unique<Check>(
          folder.path(std::to_string(index)), [&, index](const std::string& own) {
            return check_scene(random_scene(options.seed, index, own).root.text(), own);
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
    kinome::log_debug(fmt::format("{} x {}", times, reason));
  }
  std::cout << tally.scenes - tally.failed << " passed, " << tally.failed << " failed\n";
  return tally.failed == 0 ? 0 : 1;
}

int replay(const std::string& file) {
  std::ifstream in(file);
  std::stringstream contents;
  contents << in.rdbuf();
  std::string text = contents.str();
  // Each method brings its own integrator along.
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
  for (const std::string& method : check_methods()) {
    Check check(folder.path(method),
                [&](const std::string&) { return check_scene(text, home, method); });
    const CheckReport& report = check.wait();
    std::string line = method + ": ";
    if (!report.refused.empty()) line += "refused: " + report.refused;
    for (const Finding& f : report.findings) line += f.kind + ", " + f.text + "; ";
    if (report.refused.empty() && report.findings.empty()) line += "passed";
    std::cout << line << "\n";
    (report.findings.empty() ? passed : failed) += 1;
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
    std::cerr << "kinome-stress --seconds N [--seed S] [--first I] [--jobs J] [--out FOLDER]\n"
                 "kinome-stress --replay FILE\n";
    return 2;
  }
  kinome::set_log_level(kinome::LogLevel::kQuiet);
  return options.replay.empty() ? run(options) : replay(options.replay);
}

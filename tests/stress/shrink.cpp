#include "shrink.h"

#include <chrono>
#include <sstream>

#include <fmt/format.h>

#include "process.h"

namespace kinome::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kShrinking = 40;  ///< seconds per finding

bool shows(const CheckReport& report, const Finding& finding) {
  for (const Finding& f : report.findings) {
    if (f.kind != finding.kind || (!finding.method.empty() && f.method != finding.method)) continue;
    // A scene without a required part is refused, too, but for another reason.
    if (f.kind != "refused" || reason_of(f.text) == reason_of(finding.text)) return true;
  }
  return false;
}

/// Returns shorter roundings of the numbers in `value`, the simplest first.
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
  Shrinker(std::string folder, Finding finding, bool is_valid)
      : folder_(std::move(folder)), finding_(std::move(finding)), start_(Clock::now()) {
    task_.is_valid = is_valid;
    // A refusal by one method is only a finding if the others are run, too.
    const bool is_alone = finding_.kind != "refused" && finding_.method != "load";
    if (is_alone) task_.only = finding_.method;
  }

  SceneNode shrink(SceneNode scene) {
    // Each smaller scene would take the whole time limit.
    if (finding_.kind == "hang") return scene;
    bool is_smaller = true;
    while (is_smaller && in_time()) {
      is_smaller = false;
      // Large parts first; removing a node invalidates the paths after it.
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
    const auto work = [&](const std::string& folder) {
      return check_scene(scene.text(), folder, task_);
    };
    // A smaller scene that takes longer than the whole reduction is rejected.
    Check check(folder_, work, kShrinking);
    return shows(check.wait(), finding_);
  }
  std::string folder_;
  Finding finding_;
  CheckTask task_;
  Clock::time_point start_;
};

}  // namespace

SceneNode shrink(const SceneNode& scene, const Finding& finding, bool is_valid,
                 const std::string& folder) {
  return Shrinker(folder, finding, is_valid).shrink(scene);
}

}  // namespace kinome::test

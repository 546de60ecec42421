#pragma once

#include <string>
#include <vector>

/// What must hold for any scene.
namespace kinome::test {

struct Finding {
  std::string kind;    ///< "crash", "hang", "exception", "not finite", "threads", "differs"
  std::string method;  ///< of check_methods(), or "load"
  std::string text;
};

struct CheckReport {
  std::vector<Finding> findings;
  std::string refused;  ///< the error that the scene is refused with; empty: it was rendered
  int comparisons = 0;  ///< z-tests
  int open = 0;         ///< of which a single sample decides, so that they say nothing
};

/// Names of what renders the scene: integrators, and importances of `clustered`.
std::vector<std::string> check_methods();
/// The integrator's XML.
std::string integrator_of(const std::string& method);

/// Loads and renders a scene without an integrator (`text`), whose files lie in `folder`:
/// every method gives the same bits on one thread and two, nothing but finite values, and the light
/// that `direct` (or `groundtruth`, or with a bounce `path`) finds. Comparisons at kSuspicious, and
/// where one is, again with other seeds and eight times as many renders at kCertain: for normal
/// estimates that is one false alarm in 10^10 comparisons.
/// `only`: one method alone, and what it is compared with; empty: all.
CheckReport check_scene(const std::string& text, const std::string& folder,
                        const std::string& only = "");

}  // namespace kinome::test

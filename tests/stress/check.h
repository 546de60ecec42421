#pragma once

#include <array>
#include <string>
#include <vector>

#include "methods.h"

/// Conditions that any scene must meet.
namespace kinome::test {

struct Finding {
  /// "crash", "hang", "exception", "refused", "not finite", "threads", "differs"
  std::string kind;
  std::string method;  ///< a Method's name, or "load"
  std::string text;
};

struct CheckReport {
  std::vector<Finding> findings;
  /// Error with which all methods refuse the scene; empty if some rendered it.
  std::string refused;
  int comparisons = 0;  ///< z-tests
  int open = 0;         ///< comparisons that are decided by chance, and therefore give no result
  /// Reasons why significant differences and values that aren't finite were not reported as
  /// findings. Many of them indicate more than chance.
  std::vector<std::string> excuses;
};

struct CheckTask {
  /// True if the scene is valid, so that an error is a finding.
  bool is_valid = false;
  /// The only method to check, with its standard; empty: all.
  std::string only;
  std::vector<Method> methods = all_methods();
  /// Numbers of renders of the first two repetitions of a suspicious comparison. The last
  /// repetition has up to 32 times as many as the second.
  std::array<int, 2> repeated = {128, 1024};
};

/// Loads and renders a scene without an integrator (`text`), whose files are in `folder`. All
/// methods must accept it or all must refuse it. Each must return the same bits on one thread and
/// two, only finite values, and the light of its standard: `direct`, `groundtruth`, or `path` if
/// there is a bounce.
///
/// Comparisons use 16 renders at a level of 1e-4. A suspicious one is repeated with other seeds:
/// with 128 renders at 1e-6, then with 1024, then with as many as a number of samples allows: 2048
/// to 32768 (4096 for slow methods). A difference in each of them is a finding. For normally
/// distributed estimates, that is one false alarm in 10^22 comparisons. A comparison is open if a
/// few samples decide it. If one method gives a constant a thousand times, such as black, and the
/// other's estimate is sound, only the reasons in luck.h leave it open.
///
/// Differences that are significant with a thousand renders are open with an excuse
/// - if they aren't significant with more renders, for any reason;
/// - if paths with a bounce are darker in a tile, and longer paths aren't, or only a few hits of the
///   missing light are expected;
/// - if `product` without a bounce is darker in a tile and nowhere brighter, and is expected to
///   send less than one ray toward the missing light, because hidden brighter light takes its rays.
/// An excuse is also given for refusals and values that aren't finite, if a method starts at the
/// emitters of a scene whose flux exceeds single precision.
CheckReport check_scene(const std::string& text, const std::string& folder,
                        const CheckTask& task = {});

/// Returns an error's message without the location in the scene at its start.
std::string reason_of(const std::string& error);

}  // namespace kinome::test

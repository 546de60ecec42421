#pragma once

#include <array>
#include <string>
#include <vector>

#include "methods.h"

/// What must hold for any scene.
namespace kinome::test {

struct Finding {
  /// "crash", "hang", "exception", "refused", "not finite", "threads", "differs"
  std::string kind;
  std::string method;  ///< a Method's name, or "load"
  std::string text;
};

struct CheckReport {
  std::vector<Finding> findings;
  /// The error that all methods refuse the scene with; empty: some rendered it.
  std::string refused;
  int comparisons = 0;  ///< z-tests
  int open = 0;         ///< of which luck decides, so that they say nothing
  /// What sure differences were left open for, and numbers that aren't finite. Many of them say
  /// that it isn't luck.
  std::vector<std::string> excuses;
};

struct CheckTask {
  /// Whether the scene is legal, so that an error is a finding.
  bool is_valid = false;
  /// One method alone, and what it is compared with; empty: all.
  std::string only;
  std::vector<Method> methods = all_methods();
  /// Renders of the two first comparisons that repeat a suspicious one; the last has up to 32 times
  /// those of the second.
  std::array<int, 2> repeated = {128, 1024};
};

/// Loads and renders a scene without an integrator (`text`), whose files lie in `folder`: every
/// method takes it or none does, gives the same bits on one thread and two, nothing but finite
/// values, and the light that `direct` (or `groundtruth`, or with a bounce `path`) finds.
///
/// Comparisons of 16 renders at 1e-4. Where one is suspicious, again with other seeds and 128
/// renders at 1e-6, if it fails there with 1024, and then with as many as a number of samples
/// allows, 2048 to 32768 (4096 of methods that take long): what differs each time is a finding. For
/// normal estimates that is one false alarm in 10^22 comparisons. Where a few samples decide, it is
/// open; but where one method gives the same a thousand times, as a black one does, and the other's
/// estimate is sound, it is open for the reasons of luck.h alone.
///
/// Open with an excuse are differences that a thousand renders are sure of
/// - and more aren't, for whatever reason;
/// - where paths with a bounce are darker in a tile, if longer paths aren't, or if they could have
///   met what is missing but a few times;
/// - where `product` without a bounce is darker in a tile and nowhere brighter, by less than what
///   it sends one ray to beside light that is hidden from a place in sight;
/// and refusals and numbers that aren't finite of methods that start at the lights of a scene whose
/// flux leaves single precision.
CheckReport check_scene(const std::string& text, const std::string& folder,
                        const CheckTask& task = {});

/// What an error says, without the place in the scene that it names first.
std::string reason_of(const std::string& error);

}  // namespace kinome::test

#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "check.h"
#include "kinome/scene.h"
#include "measure.h"

namespace kinome::test {

/// A checked scene: its text, the scenes and renders of each method, and the report of the checks.
class CheckedScene {
 public:
  /// `task` must outlive the object. See check_scene().
  CheckedScene(const std::string& text, const std::string& folder, const CheckTask& task)
      : text_(text), folder_(folder), task_(task) {}

  const std::string& text() const { return text_; }
  const CheckTask& task() const { return task_; }
  CheckReport& report() { return report_; }

  /// Returns the scene with the method's integrator. Throws Error if it can't be loaded.
  const Scene& scene_of(const Method& method);
  bool is_loaded(const Method& method) const;
  /// Number of samples per image.
  double samples_of(const Method& method);

  /// Number of renders that renders_of() returns.
  static constexpr int kRenders = 16;
  /// Returns the renders of the first comparison.
  const Renders& renders_of(const Method& method);

  /// Returns true if the method may exceed single precision here: it follows light from the
  /// emitters, and the scene is both bright and large. Adds one excuse.
  bool has_too_much_flux(const Method& method);
  /// Adds one finding per method if some values aren't finite.
  bool is_finite(const Method& method, const Renders& renders);
  /// True if is_finite() was false for some renders of this method.
  bool was_not_finite(const Method& method) const { return not_finite_.contains(method.name); }

  /// Excludes a method, because it can't render the scene.
  void exclude(const Method& method) { excluded_.insert(method.name); }
  bool is_excluded(const Method& method) const { return excluded_.contains(method.name); }

 private:
  uint64_t first_seed(const Method& method) const;

  const std::string text_, folder_;
  const CheckTask& task_;
  CheckReport report_;
  std::set<std::string> excluded_, not_finite_;  ///< names of methods
  std::map<std::string, std::unique_ptr<Scene>> scenes_;
  std::map<std::string, Renders> renders_;
};

}  // namespace kinome::test

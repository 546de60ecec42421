#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome::loader {

/// The mistakes of a scene. Who finds one adds it and goes on as well as can be: of what a mistake
/// makes unknown, nothing is said.
class Faults {
 public:
  /// Thrown (and no Error, so that nobody takes it for one more mistake) where it makes no sense to
  /// go on.
  struct Stop {};

  /// Each that `error` holds, once. Throws Stop where there are too many.
  void add(const Error& error);
  void add(const Location& where, const std::string& message) { add(Error(where, message)); }
  [[noreturn]] void stop(const Error& error);
  /// Runs what may throw an Error, which is then added; whether it didn't.
  template <class Function>
  bool attempt(const Function& function) {
    try {
      function();
    } catch (const Error& error) {
      add(error);
      return false;
    }
    return true;
  }
  /// From now on files may be missing because of a mistake that is known.
  void expect_missing_files() { expects_missing_files_ = true; }
  /// Where an included file is asked for; the first time counts.
  void note_include(const std::string& file, const Location& asker) {
    includes_.emplace(file, asker);
  }

  bool empty() const { return all_.empty(); }
  /// The nearest of many names, for a fault to suggest; "" where there are so many faults that to
  /// look for it would take long.
  template <class Names>
  std::string nearest(const std::string& name, const Names& names) const {
    constexpr size_t kMostWithHints = 200;
    return all_.size() < kMostWithHints ? nearest_name(name, names) : "";
  }
  /// All of them by their places in the scene: what is wrong in a file, at the place that asked for
  /// it.
  std::vector<Error> sorted() const;
  /// Throws Errors if there are any.
  void check() const;

 private:
  Error with_includes(Error error) const;

  std::vector<Error> all_;
  std::set<std::string> told_;
  std::map<std::string, Location> includes_;
  bool expects_missing_files_ = false;
};

}  // namespace kinome::loader

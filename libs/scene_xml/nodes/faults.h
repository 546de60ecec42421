#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome::loader {

/// Collects the errors of a scene. Stages of the loader add errors and continue as far as possible.
/// They report nothing that may only be a consequence of an earlier error.
class Faults {
 public:
  /// Thrown to stop loading. Not an Error, so that it isn't reported as one.
  struct Stop {};

  /// Adds each error in `error`, unless it was added before. Throws Stop after too many errors.
  void add(const Error& error);
  void add(const Location& where, const std::string& message) { add(Error(where, message)); }
  [[noreturn]] void stop(const Error& error);
  /// Runs a function, and adds the Error that it throws. Returns true if it threw none.
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
  /// Ignores missing files from now on, because an error that was reported may be the reason.
  void expect_missing_files() { expects_missing_files_ = true; }
  /// Records the location of the <include> of a file; only the first one is used.
  void note_include(const std::string& file, const Location& where) {
    includes_.emplace(file, where);
  }

  bool empty() const { return all_.empty(); }
  /// Returns the nearest name, for a suggestion; "" after many errors, for which the search would
  /// take too long.
  template <class Names>
  std::string nearest(const std::string& name, const Names& names) const {
    constexpr size_t kMaxWithHints = 200;
    return all_.size() < kMaxWithHints ? nearest_name(name, names) : "";
  }
  /// Returns all errors in the order of their locations in the scene. Errors in other files are
  /// sorted by the location that refers to the file.
  std::vector<Error> sorted() const;
  /// Throws Errors if there are any.
  void check() const;

 private:
  Error with_includes(Error error) const;

  std::vector<Error> all_;
  std::set<std::string> reported_;  ///< messages
  std::map<std::string, Location> includes_;
  bool expects_missing_files_ = false;
};

}  // namespace kinome::loader

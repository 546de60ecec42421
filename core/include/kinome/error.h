#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// A place in a scene file. Line and column count from 1; line 0 means "the file as a whole", an
/// empty file "not from a file".
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
};

/// "FILE:LINE:COL", "FILE", or "".
KINOME_EXPORT std::string to_string(const Location& where);

/// Any mistake of a user's: in a scene, an asset, an option, a plugin. what() is
/// "FILE:LINE:COL: message" on one line (the prefix only where the place is known); of a file that
/// a scene names, "FILE:LINE:COL: message (referenced by SCENE:LINE:COL)".
class KINOME_EXPORT Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : Error(Location{}, message) {}
  Error(const Location& where, const std::string& message)
      : Error(where, message, std::vector<Location>()) {}
  const Location& where() const { return where_; }
  /// The message without its places.
  const std::string& message() const { return message_; }
  /// Where the file of where() is named, then where the file of that place is named, and so on.
  const std::vector<Location>& askers() const { return askers_; }
  /// The same mistake, with one more place that led to it.
  Error asked_for_by(const Location& asker) const;

 private:
  Error(const Location& where, const std::string& message, std::vector<Location> askers);

  Location where_;
  std::string message_;
  std::vector<Location> askers_;
};

/// Several mistakes at once, at least one. To those who know but Error it is the first of them.
class KINOME_EXPORT Errors : public Error {
 public:
  explicit Errors(std::vector<Error> all) : Error(all.front()), all_(std::move(all)) {}
  const std::vector<Error>& all() const { return all_; }

 private:
  std::vector<Error> all_;
};

/// The entry of `candidates` nearest to `name` by edit distance, or "" where nothing is near.
/// Range: any range of things that convert to std::string_view.
KINOME_EXPORT int edit_distance(const char* a, const char* b);
template <class Range>
std::string nearest_name(const std::string& name, const Range& candidates) {
  std::string best;
  int best_distance = 1 + static_cast<int>(name.size()) / 3;
  for (const auto& candidate : candidates) {
    const std::string c(candidate);
    const int d = edit_distance(name.c_str(), c.c_str());
    if (d <= best_distance && (best.empty() || d < best_distance)) {
      best = c;
      best_distance = d;
    }
  }
  return best;
}

}  // namespace kinome

#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// Location in a scene file. Lines and columns count from 1. Line 0 refers to the whole file; an
/// empty file name means that there is no location.
struct Location {
  std::string file;
  int line = 0;
  int column = 0;
};

/// "FILE:LINE:COL", "FILE", or "".
KINOME_EXPORT std::string to_string(const Location& where);

/// User error: in a scene, an asset, an option or a plugin. what() is "FILE:LINE:COL: message" on
/// one line, without the prefix if the location is unknown. For a file that a scene names, it is
/// "FILE:LINE:COL: message (referenced by SCENE:LINE:COL)".
class KINOME_EXPORT Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : Error(Location{}, message) {}
  Error(const Location& where, const std::string& message)
      : Error(where, message, std::vector<Location>()) {}
  const Location& where() const { return where_; }
  /// Message without locations.
  const std::string& message() const { return message_; }
  /// Chain of references: the location that refers to the file of where(), then the location that
  /// refers to that location's file, and so on.
  const std::vector<Location>& requesters() const { return requesters_; }
  /// Returns the same error with one more location that refers to it.
  Error requested_by(const Location& requester) const;

 private:
  Error(const Location& where, const std::string& message, std::vector<Location> requesters);

  Location where_;
  std::string message_;
  std::vector<Location> requesters_;
};

/// One or more errors. The base class holds the first one.
class KINOME_EXPORT Errors : public Error {
 public:
  explicit Errors(std::vector<Error> all) : Error(all.front()), all_(std::move(all)) {}
  const std::vector<Error>& all() const { return all_; }

 private:
  std::vector<Error> all_;
};

/// Returns the shortest text that reads back as this number: "0.1".
KINOME_EXPORT std::string format_number(float number);

/// Returns the Levenshtein distance of two names.
KINOME_EXPORT int edit_distance(const char* a, const char* b);
/// Returns the entry of `candidates` nearest to `name` by edit distance, or "" if none is near.
/// Range is any range whose elements convert to std::string.
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
/// Returns " (did you mean 'x'?)", or "" if `nearest` is empty.
inline std::string did_you_mean(const std::string& nearest, const std::string& prefix = "") {
  return nearest.empty() ? "" : " (did you mean '" + prefix + nearest + "'?)";
}

}  // namespace kinome

#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "loader/node.h"

namespace kinome::loader {

/// What $x stands for: -D and <default>.
class Substitution {
 public:
  Substitution(const std::map<std::string, std::string>& defines, Faults& faults);

  /// The first value of a name stays: -D beats every default.
  void add_default(const std::string& name, const std::string& value);
  /// By a mistake that is told, this name has no value; "": any may have lost its own.
  void lose(const std::string& name);
  /// An attribute's value with what stands for its $x; nullopt: it has a mistake, which is told.
  std::optional<std::string> apply(const Attribute& attribute);
  /// Adds each -D that no attribute of the scene in `file` used.
  void check_all_used(const std::string& file) const;

 private:
  const std::pair<const std::string, std::string>* longest_match(std::string_view text) const;
  size_t longest_lost(std::string_view text) const;
  size_t tell_undefined(std::string_view text, const Location& where);
  std::string hint_of(const std::string& name) const;

  std::map<std::string, std::string> values_;
  Faults& faults_;
  std::set<std::string> defines_;
  std::set<std::string> used_;
  std::set<std::string> lost_;
  std::set<std::string> suggested_;
  bool has_lost_any_ = false;
  size_t total_ = 0;
};

}  // namespace kinome::loader

#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "scene_xml/nodes/node.h"

namespace kinome::loader {

/// Replaces $x in attributes by the value of -D or <default>.
class Substitution {
 public:
  Substitution(const std::map<std::string, std::string>& defines, Faults& faults);

  /// Adds a default, unless the name has a value already, by -D or an earlier default.
  void add_default(const std::string& name, const std::string& value);
  /// Marks a name as undefined because of a reported error; "" stands for any name.
  void lose(const std::string& name);
  /// Returns an attribute's value after substitution; nullopt if an error was reported.
  std::optional<std::string> apply(const Attribute& attribute);
  /// Reports an error for each -D that no attribute of the scene in `file` used.
  void check_all_used(const std::string& file) const;

 private:
  const std::pair<const std::string, std::string>* longest_match(std::string_view text) const;
  size_t longest_lost(std::string_view text) const;
  size_t report_undefined(std::string_view text, const Location& where);
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

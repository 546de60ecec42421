#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene_xml/objects/build.h"

namespace kinome::loader {

/// Paths of a scene's objects at the time of construction. Each object has one listed path, which
/// is unique. It can also be found by other names, such as Mitsuba's, but listed paths take
/// precedence. A search takes logarithmic time.
class ObjectPaths {
 public:
  ObjectPaths(const Node& root, const Builder& builder);

  struct Entry {
    std::string path;
    const Node* node;
  };
  /// All made objects, each once, in the scene's order.
  const std::vector<Entry>& all() const { return all_; }
  /// Returns the object with a listed path, or nullptr if it is unknown.
  const Node* listed(const std::string& path) const;
  /// Returns the object with a listed path or another name, or nullptr if both are unknown.
  const Node* object(const std::string& path) const;
  /// Returns the possible splits of a path into an object and a parameter's name, the longest
  /// object path first.
  std::vector<std::pair<const Node*, std::string>> candidates(const std::string& path) const;

 private:
  using Names = std::map<std::string, const Node*, std::less<>>;

  void visit(const Node& node, const std::string& path);
  void add_names(const Node& node);
  std::string unused_path(const std::string& path, const Node& node) const;
  const Node* find(const Node& from, std::string_view path) const;

  const Node& root_;
  const Builder& builder_;
  std::vector<Entry> all_;
  Names listed_;                        ///< by listed path
  std::map<const Node*, Names> names_;  ///< for each node, its nested objects by all their names
  std::set<const Node*> known_;
};

}  // namespace kinome::loader

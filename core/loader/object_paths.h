#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loader/build.h"

namespace kinome::loader {

/// What the objects of a scene are called in the paths of their parameters, as the scene is when
/// this is made. An object is listed by one path, which no other one has; other names that it can
/// be found by (Mitsuba's, the one it has where it stands) never take the place of a listed one.
/// Finding takes logarithmic time.
class ObjectPaths {
 public:
  ObjectPaths(const Node& root, const Builder& builder);

  struct Place {
    std::string path;
    const Node* node;
  };
  /// All objects that are made, each once, by the scene's order.
  const std::vector<Place>& all() const { return all_; }
  /// The object that a path means; nullptr: none.
  const Node* object(const std::string& path) const;
  /// The object and the name of its parameter that a path may mean, the longest object first.
  std::vector<std::pair<const Node*, std::string>> candidates(const std::string& path) const;

 private:
  using Names = std::map<std::string, const Node*, std::less<>>;

  void look_at(const Node& node, const std::string& path);
  void add_names(const Node& node);
  std::string unused_path(const std::string& path, const Node& node) const;
  const Node* find(const Node& from, std::string_view path) const;

  const Node& root_;
  const Builder& builder_;
  std::vector<Place> all_;
  Names listed_;                         ///< by whole paths
  std::map<const Node*, Names> names_;  ///< of what stands in a node, all that it is called
  std::set<const Node*> known_;
};

}  // namespace kinome::loader

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loader/build.h"

namespace kinome::loader {

/// What the objects of a scene are called in the paths of their parameters.
class ObjectPaths {
 public:
  ObjectPaths(const Node& root, const Builder& builder) : root_(root), builder_(builder) {}

  struct Place {
    std::string path;
    const Node* node;
  };
  /// All objects that are made, each once, by the scene's order.
  std::vector<Place> all() const;
  /// The object and the name of its parameter that a path may mean, the longest object first.
  std::vector<std::pair<const Node*, std::string>> candidates(const std::string& path) const;

 private:
  const Node* find(const Node& from, std::string_view path) const;

  const Node& root_;
  const Builder& builder_;
};

}  // namespace kinome::loader
